//! Rays of any bits against primitives of any bits.

#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| treegen_fuzz::ray::ray(data));
