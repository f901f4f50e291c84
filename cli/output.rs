//! Writing: whole, or not at all.
//!
//! A file is written under another name in the same folder, brought to the disk, and only then given its name: whatever happens on
//! the way, there is the old file or the new one and never a part of either. Devices and pipes are written through.

use std::fs::{self, File, Metadata, OpenOptions, Permissions};
use std::io::{self, BufWriter, Cursor, ErrorKind, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};

use tempfile::NamedTempFile;
use treegen_runtime::picture::Watch;

use crate::console::shown;
use crate::exit::Failure;
use crate::supervise::Progress;

/// What contents are written into.
pub trait Sink: Write + Seek {}

impl<T: Write + Seek> Sink for T {}

/// Where something is going to be written.
#[derive(Clone, Debug)]
pub enum Place {
    /// Standard output.
    Stdout,
    /// A device or a pipe.
    Through(PathBuf),
    /// A file, new or in the place of an old one.
    File(Destination),
}

/// A file that is going to be written.
#[derive(Clone, Debug)]
pub struct Destination {
    /// As it was given.
    given: PathBuf,
    /// The folder, after all links.
    folder: PathBuf,
    /// The file itself, after all links: a link goes on pointing to it.
    path: PathBuf,
    /// What may be done with the old file, if there is one.
    permissions: Option<Permissions>,
}

/// Something written that has not got its name yet. When it is dropped, nothing is left of it.
#[derive(Debug)]
pub enum Staged {
    /// For standard output, a device or a pipe.
    Stream(Place, Vec<u8>),
    /// For a file.
    File(Destination, NamedTempFile),
}

impl Place {
    /// Finds out what is there, and whether it may be written to, before any work is done; `-` is standard output.
    ///
    /// # Errors
    /// Why nothing can be written there.
    pub fn find(path: &Path) -> Result<Self, Failure> {
        if path == Path::new("-") {
            return Ok(Self::Stdout);
        }
        match fs::metadata(path) {
            Ok(old) if old.is_dir() => Err(Failure::files("write", path, "it is a folder")),
            Ok(old) if old.is_file() => Destination::replace(path, &old).map(Self::File),
            Ok(_) => Ok(Self::Through(path.to_path_buf())),
            Err(error) if error.kind() == ErrorKind::NotFound => Destination::create(path).map(Self::File),
            Err(error) => Err(Failure::files("write", path, &error)),
        }
    }

    /// Whether it is a file, that has a name to tell its format by.
    pub fn is_file(&self) -> bool {
        matches!(self, Self::File(_))
    }

    /// Whether what is written here would take the place of `file`, under whatever name.
    pub fn is_same_as(&self, file: &Path) -> bool {
        match self {
            Self::Stdout | Self::Through(_) => false,
            Self::File(destination) => destination.path == file || is_one_file(&destination.path, file),
        }
    }

    /// A program is never overwritten by what is made from it.
    ///
    /// # Errors
    /// That one of the program's files is here.
    pub fn refuse_sources(&self, sources: &[PathBuf]) -> Result<(), Failure> {
        match sources.iter().find(|source| self.is_same_as(source)) {
            Some(source) => {
                Err(Failure::usage(format!("`{}` is the program, and would be overwritten", shown(source))))
            }
            None => Ok(()),
        }
    }

    /// Whether both are one file.
    pub fn overwrites(&self, other: &Self) -> bool {
        match (self, other) {
            (_, Self::File(other)) => self.is_same_as(&other.path),
            (Self::Stdout, Self::Stdout) => true,
            (Self::Stdout | Self::Through(_) | Self::File(_), Self::Stdout | Self::Through(_)) => false,
        }
    }

    /// Writes all, to a file under another name or into memory.
    ///
    /// # Errors
    /// The system's reason, or that the run was interrupted.
    pub fn stage(
        self,
        progress: &Progress,
        write: impl FnOnce(&mut dyn Sink) -> io::Result<()>,
    ) -> Result<Staged, Failure> {
        match self {
            Self::Stdout | Self::Through(_) => {
                let mut bytes = Cursor::new(Vec::new());
                write(&mut bytes).map_err(|error| self.fail(&error))?;
                Ok(Staged::Stream(self, bytes.into_inner()))
            }
            Self::File(destination) => {
                let file = destination.write(progress, write).map_err(|error| {
                    if progress.interrupted() {
                        Failure::interrupted()
                    } else {
                        Failure::files("write", &destination.given, &error)
                    }
                })?;
                Ok(Staged::File(destination, file))
            }
        }
    }

    /// Writes all as it is made: to a file, that gets its name when all is there, or to whoever reads.
    ///
    /// # Errors
    /// The system's reason, or that the run was interrupted.
    pub fn stream(
        self,
        progress: &Progress,
        write: impl FnOnce(&mut dyn Write) -> io::Result<()>,
    ) -> Result<(), Failure> {
        let result = match &self {
            Self::File(_) => return self.stage(progress, |out| write(&mut { out }))?.finish(),
            Self::Stdout => write_through(io::stdout().lock(), write),
            Self::Through(path) => {
                OpenOptions::new().write(true).open(path).and_then(|file| write_through(file, write))
            }
        };
        match result {
            // Whoever reads has read enough.
            Err(error) if error.kind() == ErrorKind::BrokenPipe => Ok(()),
            result => result.map_err(|error| self.fail(&error)),
        }
    }

    fn fail(&self, error: &io::Error) -> Failure {
        match self {
            Self::Stdout => Failure::files("write", Path::new("standard output"), error),
            Self::Through(path) => Failure::files("write", path, error),
            Self::File(destination) => Failure::files("write", &destination.given, error),
        }
    }
}

impl Staged {
    /// Whether to finish may take as long as whoever reads wants.
    pub fn may_block(&self) -> bool {
        matches!(self, Self::Stream(..))
    }

    /// Gives the file its name, or sends the stream on its way.
    ///
    /// # Errors
    /// The system's reason.
    pub fn finish(self) -> Result<(), Failure> {
        match self {
            Self::Stream(place, bytes) => match send(&place, &bytes) {
                // Whoever reads has read enough.
                Err(error) if error.kind() == ErrorKind::BrokenPipe => Ok(()),
                result => result.map_err(|error| place.fail(&error)),
            },
            Self::File(destination, file) => {
                file.persist(&destination.path)
                    .map_err(|error| Failure::files("write", &destination.given, &error.error))?;
                sync_folder(&destination.folder);
                Ok(())
            }
        }
    }
}

impl Destination {
    /// In the place of an old file.
    fn replace(path: &Path, old: &Metadata) -> Result<Self, Failure> {
        let fail = |error: io::Error| Failure::files("write", path, &error);
        // A file that may not be written to would be replaced all the same, since that is up to its folder: ask it.
        OpenOptions::new().write(true).open(path).map_err(fail)?;
        let target = fs::canonicalize(path).map_err(fail)?;
        Self::new(path, target, Some(old.permissions()))
    }

    /// Where nothing is yet.
    fn create(path: &Path) -> Result<Self, Failure> {
        if fs::symlink_metadata(path).is_ok_and(|it| it.is_symlink()) {
            return Err(Failure::files("write", path, "it is a link to nothing"));
        }
        let Some(name) = path.file_name() else {
            return Err(Failure::files("write", path, "it does not name a file"));
        };
        let folder = path.parent().filter(|it| !it.as_os_str().is_empty()).unwrap_or(Path::new("."));
        let folder = fs::canonicalize(folder).map_err(|error| Failure::files("write", path, &error))?;
        Self::new(path, folder.join(name), None)
    }

    fn new(given: &Path, path: PathBuf, permissions: Option<Permissions>) -> Result<Self, Failure> {
        let folder = path.parent().map(Path::to_path_buf).unwrap_or_default();
        // Better to hear now that the folder takes no files than after an hour's work.
        tempfile::tempfile_in(&folder).map_err(|error| Failure::files("write", given, reason(&error)))?;
        Ok(Self { given: given.to_path_buf(), folder, path, permissions })
    }

    fn write(
        &self,
        progress: &Progress,
        write: impl FnOnce(&mut dyn Sink) -> io::Result<()>,
    ) -> io::Result<NamedTempFile> {
        let mut builder = tempfile::Builder::new();
        builder.prefix(".treegen-").suffix(".tmp");
        #[cfg(unix)]
        builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o666));
        let file = builder.tempfile_in(&self.folder).map_err(|error| reason(&error))?;
        let mut out = BufWriter::with_capacity(1 << 16, Interruptible { file: file.as_file(), progress });
        write(&mut out)?;
        out.flush()?;
        drop(out);
        if let Some(permissions) = &self.permissions {
            file.as_file().set_permissions(permissions.clone())?;
        }
        file.as_file().sync_all()?;
        Ok(file)
    }
}

/// A file that takes no more once the run is interrupted.
struct Interruptible<'a> {
    file: &'a File,
    progress: &'a Progress,
}

impl Write for Interruptible<'_> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        if self.progress.interrupted() {
            return Err(io::Error::other("interrupted"));
        }
        self.file.write(bytes)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.file.flush()
    }
}

impl Seek for Interruptible<'_> {
    fn seek(&mut self, position: SeekFrom) -> io::Result<u64> {
        self.file.seek(position)
    }
}

/// Prints a text on standard output.
///
/// # Errors
/// The system's reason; that whoever reads has read enough is none.
pub fn print(text: &str) -> Result<(), Failure> {
    Staged::Stream(Place::Stdout, text.as_bytes().to_vec()).finish()
}

fn write_through(out: impl Write, write: impl FnOnce(&mut dyn Write) -> io::Result<()>) -> io::Result<()> {
    let mut out = BufWriter::with_capacity(1 << 16, out);
    write(&mut out)?;
    out.flush()
}

fn send(place: &Place, bytes: &[u8]) -> io::Result<()> {
    match place {
        Place::Stdout => {
            let mut out = io::stdout().lock();
            out.write_all(bytes)?;
            out.flush()
        }
        Place::Through(path) => OpenOptions::new().write(true).open(path)?.write_all(bytes),
        Place::File(destination) => fs::write(&destination.path, bytes),
    }
}

/// The bare reason: tempfile adds the name of a file that nobody has asked for.
fn reason(error: &io::Error) -> io::Error {
    error
        .raw_os_error()
        .map_or_else(|| io::Error::new(error.kind(), error.kind().to_string()), io::Error::from_raw_os_error)
}

/// A new name is on the disk when its folder is. Some file systems cannot be asked, and the file itself is there anyway.
fn sync_folder(folder: &Path) {
    if let Ok(folder) = File::open(folder) {
        let _ = folder.sync_all();
    }
}

/// Whether two paths lead to one file, as hard links do.
#[cfg(unix)]
fn is_one_file(one: &Path, other: &Path) -> bool {
    use std::os::unix::fs::MetadataExt;
    let id = |path: &Path| fs::metadata(path).map(|it| (it.dev(), it.ino()));
    matches!((id(one), id(other)), (Ok(one), Ok(other)) if one == other)
}

/// Whether two paths lead to one file.
#[cfg(not(unix))]
fn is_one_file(one: &Path, other: &Path) -> bool {
    matches!((fs::canonicalize(one), fs::canonicalize(other)), (Ok(one), Ok(other)) if one == other)
}
