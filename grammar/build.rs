//! Turns `src/grammar.lalrpop` into the tables of the parser.

use std::error::Error;

fn main() -> Result<(), Box<dyn Error>> {
    lalrpop::Configuration::new().use_cargo_dir_conventions().process()
}
