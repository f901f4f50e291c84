//! The command line: what it takes, what it says, how it ends, and that it never harms a file.

// A helper of a test fails as a test does, and prints what could not be tried.
#![allow(clippy::unwrap_used, clippy::panic, clippy::print_stdout)]

mod check;
mod commands;
mod disks;
mod exit_codes;
mod explain;
mod files;
mod fmt;
mod help;
mod hostile;
mod inspect;
mod interrupts;
mod limits;
mod measure;
mod mesh;
mod meshes;
mod output;
mod pictures;
mod same_bytes;
mod scan;
mod support;
