//! Boolean expressions over lists of intervals, against membership.

#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| treegen_fuzz::intervals::intervals(data));
