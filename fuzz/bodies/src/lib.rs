//! What the fuzzers run: each body takes any input and panics if a promise is broken.
//!
//! They stand here, apart from the fuzzers themselves, so that `cargo test` replays every stored input (`fuzz/inputs`) with nothing
//! but the stable toolchain. An input for [`draw`] is stored as the program that [`generate`] made of it, so it stays what it
//! was when the generator changes.

#![allow(clippy::expect_used, clippy::panic, reason = "a broken promise is told by a panic")]

mod bytes;
pub mod check;
pub mod draw;
pub mod generate;
pub mod intervals;
pub mod ray;
pub mod text;

use treegen_runtime::Limits;

/// Limits under which whatever an input makes grow is soon at its end: what they cannot stop is a finding.
pub fn limits() -> Limits {
    Limits {
        depth: 60,
        calls: 40,
        operations: 20_000,
        repeat: 300,
        list: 500,
        items: 1_000,
        rules: 500,
        modules: 500,
        segments: 500,
        planes: 128,
        strides: 10_000,
        steps: 10_000,
        work: 10_000_000,
        booleans: 256,
        intervals: 256,
        primitives: 2_000,
        triangles: 20_000,
        mesh_triangles: 5_000,
        mesh_nodes: 500,
        lod: 1.0,
        cell_bytes: 16 << 20,
    }
}
