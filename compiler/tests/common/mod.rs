//! What the tests of the compiler share.
#![allow(dead_code, unreachable_pub, reason = "each test uses some of it")]
#![allow(clippy::expect_used, reason = "a test that cannot go on has failed")]

use std::path::PathBuf;

use treegen_compiler::{Compiled, LoadError, Loaded, LoadedBytes, Loader, NoFiles, Options, Setting, compile, show};
use treegen_runtime::form::{Graph, Scene};

/// Finds files in one folder and below.
pub struct Folder(pub PathBuf);

impl Loader for Folder {
    fn load(&self, importer: &str, path: &str) -> Result<Loaded, LoadError> {
        let name = name(importer, path)?;
        let text = std::fs::read_to_string(self.0.join(&name)).map_err(|_| LoadError::NotFound)?;
        Ok(Loaded { name, text })
    }

    fn load_bytes(&self, importer: &str, path: &str, _most: u64) -> Result<LoadedBytes, LoadError> {
        let name = name(importer, path)?;
        let bytes = std::fs::read(self.0.join(&name)).map_err(|_| LoadError::NotFound)?;
        Ok(LoadedBytes { name, bytes })
    }
}

/// Where a path leads from a file, both below the folder.
fn name(importer: &str, path: &str) -> Result<String, LoadError> {
    let mut parts: Vec<&str> = importer.split('/').collect();
    parts.pop();
    for part in path.split('/') {
        match part {
            "." => {}
            ".." => {
                parts.pop().ok_or(LoadError::Outside)?;
            }
            _ => parts.push(part),
        }
    }
    Ok(parts.join("/"))
}

/// Compiles a program that stands alone.
pub fn compiled(text: &str) -> Compiled {
    compiled_with(text, &[])
}

/// Compiles a program that stands alone with some settings: name, value.
pub fn compiled_with(text: &str, settings: &[(&str, &str)]) -> Compiled {
    let setting = |it: &(&str, &str)| Setting { name: it.0.to_owned(), value: it.1.to_owned() };
    let options = Options { settings: settings.iter().map(setting).collect(), ..Options::default() };
    compile(Loaded { name: "test.tg".to_owned(), text: text.to_owned() }, &NoFiles, &options)
}

/// The scene of a program without mistakes.
pub fn scene(text: &str) -> Scene {
    let compiled = compiled(text);
    let problems = show(&compiled.problems, &compiled.sources, false);
    compiled.scene.expect(&problems)
}

/// The graph of a program without mistakes.
pub fn graph(text: &str) -> Graph {
    scene(text).graph
}

/// The codes of a program's problems.
pub fn codes(compiled: &Compiled) -> Vec<&'static str> {
    compiled.problems.iter().map(|it| it.code).collect()
}
