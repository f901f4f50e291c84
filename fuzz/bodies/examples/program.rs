//! Prints the program that the bytes of a file stand for: `cargo run -p treegen-fuzz --example program FILE`.

#![allow(clippy::print_stdout, reason = "that is what it is for")]

fn main() -> std::io::Result<()> {
    for path in std::env::args().skip(1) {
        print!("{}", treegen_fuzz::generate::program(&std::fs::read(path)?));
    }
    Ok(())
}
