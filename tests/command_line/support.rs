//! Runs the program in a folder of its own.

use std::fs;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};

/// A program of a few triangles' worth of work, with something in it that can be set.
pub(crate) const FRACTAL: &str = "\
param size = 1 in .1..2;
csg Fractal(order = 3 in 0..20) {
  start S(order);
  S(c) if c == 0 -> uscale(size) tetrahedron;
  S(c) -> move(.5, .5, .5) uscale(.5) S(c - 1) | move(-.5, -.5, .5) uscale(.5) S(c - 1)
        | move(.5, -.5, -.5) uscale(.5) S(c - 1) | move(-.5, .5, -.5) rotz(random(0, 90)) uscale(.5) S(c - 1);
}
scene { image { size: (40, 30) } show Fractal(); }
";

/// One solid in few pixels.
pub(crate) const SPHERE: &str = "scene { image { size: (24, 16) } show sphere; }\n";

/// A folder of its own for each test, that is gone afterwards.
pub(crate) struct Folder {
    folder: tempfile::TempDir,
}

/// What became of a run.
pub(crate) struct Ran {
    pub(crate) code: Option<i32>,
    pub(crate) out: Vec<u8>,
    pub(crate) said: String,
}

impl Folder {
    /// A folder with these files in it.
    pub(crate) fn with(files: &[(&str, &str)]) -> Self {
        let folder = tempfile::Builder::new().prefix("treegen-test-").tempdir().unwrap();
        let folder = Self { folder };
        for (name, text) in files {
            let path = folder.path(name);
            fs::create_dir_all(path.parent().unwrap()).unwrap();
            fs::write(path, text).unwrap();
        }
        folder
    }

    pub(crate) fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    pub(crate) fn read(&self, name: &str) -> Vec<u8> {
        fs::read(self.path(name)).unwrap_or_else(|error| panic!("{name}: {error}"))
    }

    pub(crate) fn write(&self, name: &str, bytes: &[u8]) {
        fs::write(self.path(name), bytes).unwrap();
    }

    pub(crate) fn exists(&self, name: &str) -> bool {
        fs::symlink_metadata(self.path(name)).is_ok()
    }

    /// The names of all that lies in it, in order.
    pub(crate) fn names(&self) -> Vec<String> {
        let entries = fs::read_dir(self.folder.path()).unwrap();
        let mut names: Vec<String> = entries.map(|it| it.unwrap().file_name().to_string_lossy().into_owned()).collect();
        names.sort();
        names
    }

    /// The program, about to run here.
    pub(crate) fn command(&self, arguments: &[&str]) -> Command {
        let mut command = treegen(self.folder.path());
        command.args(arguments);
        command
    }

    /// Runs the program here.
    pub(crate) fn run(&self, arguments: &[&str]) -> Ran {
        ran(&self.command(arguments).stdin(Stdio::null()).output().unwrap())
    }

    /// Runs the program here and gives it something to read.
    pub(crate) fn run_with_input(&self, arguments: &[&str], input: &[u8]) -> Ran {
        let mut command = self.command(arguments);
        let mut child = command.stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
        // It may end before it has read all.
        let _ = child.stdin.take().unwrap().write_all(input);
        ran(&child.wait_with_output().unwrap())
    }

    /// Runs the program here as somebody who owns nothing of this; nothing if that cannot be done.
    ///
    /// The superuser may read and write everything: as such no test would see what happens to others.
    #[cfg(unix)]
    pub(crate) fn run_as_stranger(&self, arguments: &[&str]) -> Option<Ran> {
        use std::os::unix::process::CommandExt;
        const NOBODY: u32 = 65_534;
        let mut command = self.command(arguments);
        command.stdin(Stdio::null()).uid(NOBODY).gid(NOBODY).output().ok().map(|it| ran(&it))
    }

    /// Sets who may do what with a file or folder here.
    #[cfg(unix)]
    pub(crate) fn allow(&self, name: &str, mode: u32) {
        let permissions = std::os::unix::fs::PermissionsExt::from_mode(mode);
        fs::set_permissions(self.path(name), permissions).unwrap();
    }

    /// Runs a line of shell here, in which `$treegen` is the program.
    #[cfg(unix)]
    pub(crate) fn shell(&self, line: &str) -> Ran {
        let mut command = Command::new("sh");
        command.arg("-c").arg(line).current_dir(self.folder.path()).env("treegen", env!("CARGO_BIN_EXE_treegen"));
        ran(&command.stdin(Stdio::null()).output().unwrap())
    }
}

impl Ran {
    /// Fails unless it ended so.
    #[track_caller]
    pub(crate) fn ended(self, code: i32) -> Self {
        assert_eq!(self.code, Some(code), "{}", self.said);
        self
    }

    /// Fails unless it said all of this.
    #[track_caller]
    pub(crate) fn saying(self, parts: &[&str]) -> Self {
        for part in parts {
            assert!(self.said.contains(part), "{part:?} is not in:\n{}", self.said);
        }
        self
    }
}

/// A picture as 8-bit RGBA, row by row, with its size.
pub(crate) fn pixels(png: &[u8]) -> (u32, u32, Vec<u8>) {
    let picture = image::load_from_memory_with_format(png, image::ImageFormat::Png).unwrap().to_rgba8();
    (picture.width(), picture.height(), picture.into_raw())
}

/// The texts in a PNG.
pub(crate) fn texts(png: &[u8]) -> Vec<(String, String)> {
    let mut reader = png::Decoder::new(std::io::Cursor::new(png)).read_info().unwrap();
    let mut bytes = vec![0; reader.output_buffer_size().unwrap()];
    reader.next_frame(&mut bytes).unwrap();
    let info = reader.info();
    info.uncompressed_latin1_text.iter().map(|it| (it.keyword.clone(), it.text.clone())).collect()
}

fn treegen(folder: &Path) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_treegen"));
    // Help is wrapped to the width of the terminal, and colours are asked of the environment.
    command.current_dir(folder).env("COLUMNS", "100").env_remove("CLICOLOR_FORCE").env_remove("NO_COLOR");
    command
}

fn ran(output: &Output) -> Ran {
    let said = String::from_utf8(output.stderr.clone()).unwrap();
    assert!(!said.contains("panicked"), "{said}");
    Ran { code: output.status.code(), out: output.stdout.clone(), said }
}
