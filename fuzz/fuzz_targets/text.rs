//! Any text through the lexer, the parser and the formatter.

#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| treegen_fuzz::text::text(&String::from_utf8_lossy(data)));
