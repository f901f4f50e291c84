//! Reading: the program, and what it uses, from below its root folder and from nowhere else.
//!
//! The root is the folder that the program lies in. A path in a `use` is first resolved as text, so that one that climbs out of the
//! root is refused before the file system is asked, then by the file system, and whatever lies outside after all links are
//! followed is refused, too. Every file is read once: all that a run says and shows comes from one state of it.

use std::cell::RefCell;
use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::fs::{self, File};
use std::io::{self, Read};
use std::path::{Component, Path, PathBuf};

use sha2::{Digest, Sha256};
use treegen_compiler::{LoadError, Loaded, LoadedBytes, Loader};

use crate::console::shown;
use crate::exit::{Exit, Failure};

/// Bytes of one file.
pub const MAX_BYTES: u64 = 4 << 20;

/// The files of one program.
#[derive(Debug)]
pub struct Files {
    /// The canonical path of the folder that everything used must lie in.
    root: PathBuf,
    /// What messages put before a path from the root: the folder as it was given, so that editors find the file.
    prefix: PathBuf,
    main: Main,
    /// What was used, by its path from the root.
    used: RefCell<BTreeMap<PathBuf, String>>,
    /// The hashes of the pictures and meshes that were read, likewise.
    pictures: RefCell<BTreeMap<PathBuf, [u8; 32]>>,
}

#[derive(Debug)]
struct Main {
    /// The name in messages.
    name: String,
    /// Its canonical path; none for standard input.
    path: Option<PathBuf>,
    text: String,
}

impl Files {
    /// Reads the program; `-` is standard input, and its root the current folder.
    ///
    /// # Errors
    /// What is wrong with the file.
    pub fn open(path: &Path) -> Result<Self, Failure> {
        if path == Path::new("-") { Self::open_stdin() } else { Self::open_file(path) }
    }

    fn open_stdin() -> Result<Self, Failure> {
        let name = Path::new("standard input");
        let bytes = read_limited(&mut io::stdin().lock()).map_err(|error| Failure::files("read", name, &error))?;
        let text = text_of(bytes, name)?;
        let root = fs::canonicalize(".").map_err(|error| Failure::files("read", Path::new("."), &error))?;
        let main = Main { name: "<standard input>".to_owned(), path: None, text };
        Ok(Self { root, prefix: PathBuf::new(), main, used: RefCell::default(), pictures: RefCell::default() })
    }

    fn open_file(path: &Path) -> Result<Self, Failure> {
        let canonical = fs::canonicalize(path).map_err(|error| not_found(path, &error))?;
        check_regular(&canonical, path)?;
        let read = || read_limited(&mut File::open(&canonical)?);
        let text = text_of(read().map_err(|error| Failure::files("read", path, &error))?, path)?;
        let root = canonical.parent().map(Path::to_path_buf).unwrap_or_default();
        let given = path.parent().unwrap_or(Path::new(""));
        let here = if given.as_os_str().is_empty() { Path::new(".") } else { given };
        // A program that is a link uses what lies beside the file it stands for.
        let prefix = if fs::canonicalize(here).is_ok_and(|it| it == root) { given.to_path_buf() } else { root.clone() };
        let main = Main { name: shown(path), path: Some(canonical), text };
        Ok(Self { root, prefix, main, used: RefCell::default(), pictures: RefCell::default() })
    }

    /// The program itself.
    pub fn main(&self) -> Loaded {
        Loaded { name: self.main.name.clone(), text: self.main.text.clone() }
    }

    /// The canonical paths of all that was read.
    pub fn paths(&self) -> Vec<PathBuf> {
        let (used, pictures) = (self.used.borrow(), self.pictures.borrow());
        let inside = used.keys().chain(pictures.keys()).map(|it| self.root.join(it));
        self.main.path.iter().cloned().chain(inside).collect()
    }

    /// The canonical path of the file that messages call so.
    pub fn path_of(&self, name: &str) -> Option<PathBuf> {
        if self.main.name == name {
            return self.main.path.clone();
        }
        let used = self.used.borrow();
        used.keys().find(|it| self.name_of(it) == name).map(|it| self.root.join(it))
    }

    /// A hash of all that was read: SHA-256 of the program, then of each used file's path from the root and text, each after a byte
    /// 0; then of each picture's path and its own SHA-256, each after a byte 0. It does not depend on a byte-order mark, on how lines end, or on blank space at the end; so of a program that uses
    /// nothing, and ends with one line end, it is what `sha256sum` prints.
    pub fn fingerprint(&self) -> String {
        let mut hash = Sha256::new();
        hash.update(plain(&self.main.text));
        for (path, text) in self.used.borrow().iter() {
            hash.update([0]);
            hash.update(slashed(path));
            hash.update([0]);
            hash.update(plain(text));
        }
        for (path, picture) in self.pictures.borrow().iter() {
            hash.update([0]);
            hash.update(slashed(path));
            hash.update([0]);
            hash.update(picture);
        }
        hash.finalize().iter().fold(String::new(), |mut text, byte| {
            let _ = write!(text, "{byte:02x}");
            text
        })
    }

    /// The folder, as a path from the root, of the file that messages call so.
    fn folder_of(&self, name: &str) -> PathBuf {
        let used = self.used.borrow();
        let path = used.keys().find(|it| self.name_of(it) == name);
        path.and_then(|it| it.parent()).map(Path::to_path_buf).unwrap_or_default()
    }

    fn name_of(&self, path: &Path) -> String {
        shown(self.prefix.join(path))
    }

    /// The path from the root of what a `use` names.
    fn locate(&self, importer: &str, path: &str) -> Result<PathBuf, LoadError> {
        let wanted = resolve(&self.folder_of(importer), Path::new(path))?;
        let canonical = fs::canonicalize(self.root.join(wanted)).map_err(|error| refused(&error))?;
        let inside = canonical.strip_prefix(&self.root).map_err(|_| LoadError::Outside)?;
        Ok(inside.to_path_buf())
    }

    fn read(&self, inside: &Path) -> Result<String, LoadError> {
        let bytes = self.read_bytes(inside, MAX_BYTES)?;
        String::from_utf8(bytes).map_err(|error| LoadError::NotText { at: error.utf8_error().valid_up_to() })
    }

    fn read_bytes(&self, inside: &Path, most: u64) -> Result<Vec<u8>, LoadError> {
        let path = self.root.join(inside);
        let kind = fs::metadata(&path).map_err(|error| refused(&error))?;
        if !kind.is_file() {
            return Err(LoadError::Refused("it is not a file".to_owned()));
        }
        let bytes = File::open(&path).and_then(|mut file| read_at_most(&mut file, most));
        bytes.map_err(|error| refused(&error))?.ok_or(LoadError::TooLarge)
    }
}

impl Loader for Files {
    fn load(&self, importer: &str, path: &str) -> Result<Loaded, LoadError> {
        let inside = self.locate(importer, path)?;
        if self.main.path.as_ref() == Some(&self.root.join(&inside)) {
            return Ok(self.main());
        }
        let name = self.name_of(&inside);
        if let Some(text) = self.used.borrow().get(&inside) {
            return Ok(Loaded { name, text: text.clone() });
        }
        let text = self.read(&inside)?;
        self.used.borrow_mut().insert(inside, text.clone());
        Ok(Loaded { name, text })
    }

    fn load_bytes(&self, importer: &str, path: &str, most: u64) -> Result<LoadedBytes, LoadError> {
        let inside = self.locate(importer, path)?;
        let bytes = self.read_bytes(&inside, most)?;
        let name = self.name_of(&inside);
        self.pictures.borrow_mut().insert(inside, Sha256::digest(&bytes).into());
        Ok(LoadedBytes { name, bytes })
    }

    fn name_of_bytes(&self, importer: &str, path: &str) -> Option<String> {
        self.locate(importer, path).ok().map(|it| self.name_of(&it))
    }
}

/// Where `path` leads from `folder`, both seen from the root, by the text alone.
fn resolve(folder: &Path, path: &Path) -> Result<PathBuf, LoadError> {
    let mut resolved = folder.to_path_buf();
    for component in path.components() {
        match component {
            Component::Normal(name) => resolved.push(name),
            Component::CurDir => {}
            Component::ParentDir if resolved.pop() => {}
            Component::ParentDir | Component::RootDir | Component::Prefix(_) => return Err(LoadError::Outside),
        }
    }
    Ok(resolved)
}

/// All bytes; none when there are more than a source text may have.
fn read_limited(from: &mut impl Read) -> io::Result<Option<Vec<u8>>> {
    read_at_most(from, MAX_BYTES)
}

/// All bytes; none when there are more than so many.
fn read_at_most(from: &mut impl Read, most: u64) -> io::Result<Option<Vec<u8>>> {
    let mut bytes = Vec::new();
    from.take(most + 1).read_to_end(&mut bytes)?;
    Ok((bytes.len() as u64 <= most).then_some(bytes))
}

fn text_of(bytes: Option<Vec<u8>>, path: &Path) -> Result<String, Failure> {
    let name = shown(path);
    let Some(bytes) = bytes else {
        let text = format!("`{name}` is larger than {} MiB, the most a program may have", MAX_BYTES >> 20);
        return Err(Failure::new(Exit::Limit, text));
    };
    let known = kind_of(&bytes);
    String::from_utf8(bytes).map_err(|error| {
        let at = error.utf8_error().valid_up_to();
        let failure =
            Failure::new(Exit::Program, format!("`{name}` is not text in UTF-8: byte {at} belongs to no character"));
        match known {
            Some(kind) => failure.help(format!("it looks like {kind}")),
            None => failure.help("save it as UTF-8"),
        }
    })
}

/// What bytes that are no UTF-8 probably are, by how they begin.
fn kind_of(bytes: &[u8]) -> Option<&'static str> {
    const KINDS: [(&[u8], &str); 9] = [
        (b"\xff\xfe\0\0", "UTF-32: save it as UTF-8"),
        (b"\0\0\xfe\xff", "UTF-32: save it as UTF-8"),
        (b"\xff\xfe", "UTF-16: save it as UTF-8"),
        (b"\xfe\xff", "UTF-16: save it as UTF-8"),
        (b"\x89PNG", "a PNG picture, not a program"),
        (b"\xff\xd8\xff", "a JPEG picture, not a program"),
        (b"\x76\x2f\x31\x01", "an OpenEXR picture, not a program"),
        (b"\x1f\x8b", "a gzip archive: unpack it first"),
        (b"\x7fELF", "a program for a processor, not for treegen"),
    ];
    KINDS.iter().find(|it| bytes.starts_with(it.0)).map(|it| it.1)
}

/// Text without what editors and version control change on their own.
fn plain(text: &str) -> String {
    let text = text.strip_prefix('\u{feff}').unwrap_or(text);
    text.trim_end().replace("\r\n", "\n") + "\n"
}

/// A path as it is written in a `use`, on every system.
fn slashed(path: &Path) -> String {
    let parts: Vec<_> = path.components().map(|it| it.as_os_str().to_string_lossy()).collect();
    parts.join("/")
}

/// Pipes and devices are never opened: they may have no end, or wait for a writer who never comes.
fn check_regular(canonical: &Path, given: &Path) -> Result<(), Failure> {
    let kind = fs::metadata(canonical).map_err(|error| Failure::files("read", given, &error))?;
    if kind.is_file() {
        return Ok(());
    }
    let what = if kind.is_dir() { "it is a folder" } else { "it is not a file" };
    let failure = Failure::files("read", given, what);
    Err(if kind.is_dir() {
        failure
    } else {
        failure.help("to read a program from a pipe, give `-` and use standard input")
    })
}

fn not_found(path: &Path, error: &io::Error) -> Failure {
    let failure = Failure::files("read", path, error);
    let with_extension = path.with_added_extension("tg");
    if error.kind() == io::ErrorKind::NotFound && with_extension.is_file() {
        return failure.help(format!("there is `{}`", shown(with_extension)));
    }
    failure
}

/// A reason that names no path: what lies outside the root is nobody's business, not even its name.
fn refused(error: &io::Error) -> LoadError {
    match error.kind() {
        io::ErrorKind::NotFound | io::ErrorKind::NotADirectory | io::ErrorKind::InvalidInput => LoadError::NotFound,
        _ => LoadError::Refused(error.to_string()),
    }
}

#[cfg(test)]
mod tests {
    use super::{Files, plain, resolve};
    use std::fs;
    use std::path::{Path, PathBuf};
    use treegen_compiler::{LoadError, Loader};

    fn folder_with(files: &[(&str, &str)]) -> tempfile::TempDir {
        let folder = tempfile::tempdir().unwrap();
        for (name, text) in files {
            let path = folder.path().join(name);
            fs::create_dir_all(path.parent().unwrap()).unwrap();
            fs::write(path, text).unwrap();
        }
        folder
    }

    #[test]
    fn a_path_is_resolved_by_its_text_and_never_above_the_root() {
        let from = |folder: &str, path: &str| resolve(Path::new(folder), Path::new(path));
        assert_eq!(from("", "a/b.tg"), Ok(PathBuf::from("a/b.tg")));
        assert_eq!(from("a", "../b.tg"), Ok(PathBuf::from("b.tg")));
        assert_eq!(from("a", "./x/../b.tg"), Ok(PathBuf::from("a/b.tg")));
        for outside in ["../b.tg", "a/../../b.tg", "/etc/hostname", "/"] {
            assert_eq!(from("", outside), Err(LoadError::Outside), "{outside}");
        }
        assert_eq!(from("a", "../../b.tg"), Err(LoadError::Outside));
    }

    #[test]
    fn used_files_are_found_from_the_file_that_names_them() {
        let folder = folder_with(&[("main.tg", "m"), ("lib/a.tg", "a"), ("lib/b.tg", "b"), ("b.tg", "another b")]);
        let main = folder.path().join("main.tg");
        let files = Files::open(&main).ok().unwrap();
        let a = files.load(&files.main().name, "lib/a.tg").unwrap();
        assert_eq!(files.load(&a.name, "b.tg").unwrap().text, "b");
        assert_eq!(files.load(&a.name, "../b.tg").unwrap().text, "another b");
        assert_eq!(files.load(&a.name, "../lib/./a.tg").unwrap().name, a.name);
        assert_eq!(files.paths().len(), 4);
    }

    #[test]
    fn every_file_is_read_once() {
        let folder = folder_with(&[("main.tg", "m"), ("a.tg", "before")]);
        let files = Files::open(&folder.path().join("main.tg")).ok().unwrap();
        let name = files.main().name;
        assert_eq!(files.load(&name, "a.tg").unwrap().text, "before");
        fs::write(folder.path().join("a.tg"), "after").unwrap();
        fs::write(folder.path().join("main.tg"), "after").unwrap();
        assert_eq!(files.load(&name, "a.tg").unwrap().text, "before");
        assert_eq!(files.load(&name, "main.tg").unwrap().text, "m");
    }

    #[test]
    fn what_a_path_leads_to_has_one_name_before_and_after_it_is_read() {
        let folder = folder_with(&[("main.tg", ""), ("lib/rock.obj", "v 0 0 0"), ("lib/a.tg", "")]);
        let files = Files::open(&folder.path().join("main.tg")).ok().unwrap();
        let name = files.main().name;
        let used = files.load(&name, "lib/a.tg").unwrap().name;
        let read = files.load_bytes(&name, "lib/rock.obj", 100).unwrap().name;
        for (importer, path) in [(&name, "lib/rock.obj"), (&name, "./lib/../lib/rock.obj"), (&used, "rock.obj")] {
            assert_eq!(files.name_of_bytes(importer, path).as_ref(), Some(&read), "{path}");
        }
        assert_eq!(files.name_of_bytes(&name, "../rock.obj"), None);
    }

    #[test]
    fn what_is_not_text_or_too_large_is_told_apart() {
        let folder = folder_with(&[("main.tg", ""), ("large.tg", &" ".repeat((4 << 20) + 1)), ("folder/x", "")]);
        fs::write(folder.path().join("latin.tg"), b"// caf\xe9").unwrap();
        let files = Files::open(&folder.path().join("main.tg")).ok().unwrap();
        let load = |path: &str| files.load(&files.main().name, path).map(|it| it.text);
        assert_eq!(load("latin.tg"), Err(LoadError::NotText { at: 6 }));
        assert_eq!(load("large.tg"), Err(LoadError::TooLarge));
        assert_eq!(load("absent.tg"), Err(LoadError::NotFound));
        assert_eq!(load("a\0b.tg"), Err(LoadError::NotFound));
        assert!(matches!(load("folder"), Err(LoadError::Refused(_))));
        assert!(matches!(load(&"x".repeat(5000)), Err(LoadError::Refused(_))));
    }

    #[test]
    fn the_fingerprint_is_that_of_the_meaning_not_of_the_line_ends() {
        let of = |text: &str| {
            let folder = folder_with(&[("main.tg", text)]);
            Files::open(&folder.path().join("main.tg")).ok().unwrap().fingerprint()
        };
        // From `printf 'abc\n' | sha256sum`.
        assert_eq!(of("abc\n"), "edeaaff3f1774ad2888673770c6d64097e391bc362d7d6fb34982ddf0efd18cb");
        assert_eq!(of("\u{feff}abc\r\n\r\n"), of("abc\n"));
        assert_ne!(of("abd"), of("abc"));
        assert_eq!(plain("a\r\nb"), "a\nb\n");
    }

    #[test]
    fn the_fingerprint_knows_the_used_files() {
        let folder = folder_with(&[("main.tg", ""), ("a.tg", "a"), ("b.tg", "b")]);
        let of = |path: Option<&str>| {
            let files = Files::open(&folder.path().join("main.tg")).ok().unwrap();
            path.map(|it| files.load(&files.main().name, it).unwrap());
            files.fingerprint()
        };
        assert_ne!(of(None), of(Some("a.tg")));
        assert_ne!(of(Some("b.tg")), of(Some("a.tg")));
    }
}
