#![no_main]
use granum_fuzz::checks;

libfuzzer_sys::fuzz_target!(|data: &[u8]| checks::bonds(data));
