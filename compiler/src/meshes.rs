//! The meshes that a program names: each file is read once, whatever names it.

use std::collections::HashMap;
use std::sync::Arc;

use treegen_grammar::{FileId, Span};
use treegen_runtime::form::{MeshId, PrimitiveKind};
use treegen_runtime::geometry::Triangles;
use treegen_runtime::obj::{BadMesh, decode_obj};

use crate::loader::{LoadedBytes, Loader};
use crate::problem::Problem;
use crate::sources::Sources;
use crate::words;

/// How many bytes a mesh's file may have.
pub(crate) const MAX_BYTES: u64 = 256 << 20;

/// Finds meshes.
pub(crate) struct Meshes<'l> {
    loader: &'l dyn Loader,
    sources: &'l Sources,
    meshes: Vec<Arc<Triangles>>,
    /// Those that were read, by the names of their files.
    known: HashMap<String, MeshId>,
    /// What paths lead to, by the files in which they stand; nothing where a problem was told.
    asked: HashMap<(FileId, String), Option<MeshId>>,
    /// How many triangles there may be, and how many more.
    most: u64,
    left: u64,
}

impl<'l> Meshes<'l> {
    pub(crate) fn new(loader: &'l dyn Loader, sources: &'l Sources, most: u64) -> Self {
        let (known, asked) = (HashMap::new(), HashMap::new());
        Self { loader, sources, meshes: Vec::new(), known, asked, most, left: most }
    }

    /// All that were found, in the order of their numbers.
    pub(crate) fn into_meshes(self) -> Vec<Arc<Triangles>> {
        self.meshes
    }

    /// The primitive that a path names in the file where the span is; nothing if what is wrong with it was told before.
    ///
    /// # Errors
    /// What is wrong with it.
    pub(crate) fn find(&mut self, path: &str, span: Span) -> Result<Option<PrimitiveKind>, Problem> {
        let asked = (span.file, path.to_owned());
        let found = match self.asked.get(&asked) {
            Some(found) => *found,
            None => {
                let read = self.read(path, span);
                self.asked.insert(asked, read.as_ref().ok().copied());
                Some(read?)
            }
        };
        Ok(found.map(|mesh| PrimitiveKind::Mesh { mesh, closed: self.get(mesh).gap().is_none() }))
    }

    /// A mesh that was found.
    pub(crate) fn get(&self, mesh: MeshId) -> &Triangles {
        &self.meshes[mesh.0 as usize]
    }

    fn read(&mut self, path: &str, span: Span) -> Result<MeshId, Problem> {
        let importer = self.sources.get(span.file).map_or("", |it| it.name.as_str());
        let name = self.loader.name_of_bytes(importer, path);
        if let Some(known) = name.and_then(|it| self.known.get(&it)) {
            return Ok(*known);
        }
        let loaded = self.loader.load_bytes(importer, path, MAX_BYTES);
        let loaded = loaded.map_err(|why| words::files::data_not_loaded("a mesh's", path, span, &why, MAX_BYTES))?;
        if let Some(known) = self.known.get(&loaded.name) {
            return Ok(*known);
        }
        let LoadedBytes { name, bytes } = loaded;
        let mesh = decode_obj(bytes, self.left).map_err(|why| match why {
            BadMesh::TooMany { line } => words::files::too_many_triangles(path, line, (self.left, self.most), span),
            why => words::files::bad_mesh(path, span, &why),
        })?;
        self.left -= mesh.count() as u64;
        let id = MeshId(self.meshes.len() as u32);
        self.meshes.push(Arc::new(mesh));
        self.known.insert(name, id);
        Ok(id)
    }
}
