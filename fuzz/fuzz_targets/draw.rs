//! Programs made from bytes, drawn small in every way there is.

#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| {
    treegen_fuzz::draw::draw(&treegen_fuzz::generate::program(data));
});
