//! The pictures that textures show: each file is read once, whatever names it.

use std::collections::HashMap;
use std::sync::Arc;

use treegen_grammar::Span;
use treegen_runtime::form::Raster;
use treegen_runtime::texture::{BadPicture, decode_png};

use crate::loader::Loader;
use crate::problem::Problem;
use crate::sources::Sources;
use crate::words;

/// How many bytes a picture's file may have.
pub(crate) const MAX_BYTES: u64 = 64 << 20;

/// How many pixels all pictures of a program may have.
pub(crate) const MAX_PIXELS: u64 = 1 << 24;

/// Finds pictures.
pub(crate) struct Pictures<'l> {
    loader: &'l dyn Loader,
    sources: &'l Sources,
    /// Those that were decoded, by the names of their files.
    known: HashMap<String, Arc<Raster>>,
    /// How many more pixels there may be.
    left: u64,
}

impl<'l> Pictures<'l> {
    pub(crate) fn new(loader: &'l dyn Loader, sources: &'l Sources) -> Self {
        Self { loader, sources, known: HashMap::new(), left: MAX_PIXELS }
    }

    /// The picture that a path names in the file where the span is.
    ///
    /// # Errors
    /// What is wrong with it.
    pub(crate) fn find(&mut self, path: &str, span: Span) -> Result<Arc<Raster>, Problem> {
        let importer = self.sources.get(span.file).map_or("", |it| it.name.as_str());
        let name = self.loader.name_of_bytes(importer, path);
        if let Some(known) = name.and_then(|it| self.known.get(&it)) {
            return Ok(Arc::clone(known));
        }
        let loaded = self.loader.load_bytes(importer, path, MAX_BYTES);
        let loaded = loaded.map_err(|why| words::files::data_not_loaded("a picture's", path, span, &why, MAX_BYTES))?;
        if let Some(known) = self.known.get(&loaded.name) {
            return Ok(Arc::clone(known));
        }
        let raster = decode_png(&loaded.bytes, self.left).map_err(|why| match why {
            BadPicture::TooLarge { width, height } => {
                words::files::too_many_pixels(path, (width, height), self.left, MAX_PIXELS, span)
            }
            BadPicture::NotPng | BadPicture::Broken(_) => words::files::bad_picture(path, span, &why),
        })?;
        self.left -= u64::from(raster.width()) * u64::from(raster.height());
        let raster = Arc::new(raster);
        self.known.insert(loaded.name, Arc::clone(&raster));
        Ok(raster)
    }
}
