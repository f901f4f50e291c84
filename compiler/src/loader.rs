//! How used files are found. The library opens no file itself: whoever calls it brings a [`Loader`].

/// Finds the files that a program uses.
///
/// Paths are relative to the file that names them and may not leave the root folder of the program; the loader sees to that.
pub trait Loader {
    /// The file that `path` names in the file called `importer`.
    ///
    /// # Errors
    /// Why there is none.
    fn load(&self, importer: &str, path: &str) -> Result<Loaded, LoadError>;

    /// The bytes of the file that `path` names in the file called `importer`, with so many at most. A loader that knows texts only
    /// finds none.
    ///
    /// # Errors
    /// Why there is none.
    fn load_bytes(&self, _importer: &str, _path: &str, _most: u64) -> Result<LoadedBytes, LoadError> {
        Err(LoadError::NotFound)
    }

    /// What [`Self::load_bytes`] would call that file, if that is known without reading it: what was read by another path is then not
    /// read again.
    fn name_of_bytes(&self, _importer: &str, _path: &str) -> Option<String> {
        None
    }
}

/// A file that is no text.
#[derive(Clone, Debug)]
pub struct LoadedBytes {
    /// Its name, as [`Loaded::name`].
    pub name: String,
    /// What is in it.
    pub bytes: Vec<u8>,
}

/// A file that was read.
#[derive(Clone, Debug)]
pub struct Loaded {
    /// Its name: shown to people, and the same for the same file whatever path led to it.
    pub name: String,
    /// Its text.
    pub text: String,
}

/// Why a file was not read.
#[derive(Clone, Debug, PartialEq)]
pub enum LoadError {
    /// There is no such file.
    NotFound,
    /// The path leads out of the program's root folder.
    Outside,
    /// It is not valid UTF-8 from this byte on.
    NotText {
        /// Offset of the first byte that is wrong.
        at: usize,
    },
    /// It is larger than a source text may be.
    TooLarge,
    /// The system refused, with its reason.
    Refused(String),
}

/// A loader for programs that stand alone: it finds nothing.
#[derive(Clone, Copy, Debug, Default)]
pub struct NoFiles;

impl Loader for NoFiles {
    fn load(&self, _importer: &str, _path: &str) -> Result<Loaded, LoadError> {
        Err(LoadError::NotFound)
    }
}
