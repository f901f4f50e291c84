//! Export: a scene walked down to its primitives, and the files other programs read.
//!
//! In comes a [`Scene`](crate::form::Scene); out come [`Pieces`], one after another, in the order written. Nothing is kept of what
//! is passed, so what it takes does not grow with the number of primitives but with the nesting of the rules. The writers ask for
//! a piece, write it, and ask for the next. What a shape derived to is written apart: [`write_form`].
//!
//! Meshes are made first ([`mesh`](crate::mesh)), then written: as glTF with its instances, or triangle after triangle.

mod decompose;
mod form;
mod gltf;
mod gltf_json;
mod json;
mod look;
mod obj;
mod piece;
mod pieces;
mod ply;
mod pov;
mod pov_scene;
mod pov_solid;

pub use form::{PlacedSolid, write_form};
pub use gltf::write_gltf;
pub use json::write_json;
pub use obj::{write_mtl, write_obj};
pub use piece::{Boolean, Piece, Placed};
pub use pieces::Pieces;
pub use ply::write_ply;
pub use pov::write_pov;

use std::fmt;
use std::io;

use crate::fault::Fault;

/// Why an export ended early.
#[derive(Debug)]
pub enum ExportError {
    /// The scene has a fault, or more primitives than the limit.
    Fault(Box<Fault>),
    /// The file does not take any more.
    Write(io::Error),
}

impl fmt::Display for ExportError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Fault(fault) => write!(f, "{:?}", fault.kind),
            Self::Write(error) => error.fmt(f),
        }
    }
}

impl std::error::Error for ExportError {}

impl From<Fault> for ExportError {
    fn from(fault: Fault) -> Self {
        Self::Fault(Box::new(fault))
    }
}

impl From<io::Error> for ExportError {
    fn from(error: io::Error) -> Self {
        Self::Write(error)
    }
}
