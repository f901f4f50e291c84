//! Any text through the compiler, and its safe suggestions.

#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| treegen_fuzz::check::check(&String::from_utf8_lossy(data)));
