//! Finds what a program uses beside it.

use std::path::Path;

use treegen_compiler::{LoadError, Loaded, LoadedBytes, Loader};

/// The files in the folder of a program.
pub(crate) struct Beside<'p>(pub(crate) &'p Path);

impl Loader for Beside<'_> {
    fn load(&self, _importer: &str, path: &str) -> Result<Loaded, LoadError> {
        let text = std::fs::read_to_string(self.0.with_file_name(path)).map_err(|_| LoadError::NotFound)?;
        Ok(Loaded { name: path.to_owned(), text })
    }

    fn load_bytes(&self, _importer: &str, path: &str, _most: u64) -> Result<LoadedBytes, LoadError> {
        let bytes = std::fs::read(self.0.with_file_name(path)).map_err(|_| LoadError::NotFound)?;
        Ok(LoadedBytes { name: path.to_owned(), bytes })
    }
}
