#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| mollis_fuzz::points(bytes));
