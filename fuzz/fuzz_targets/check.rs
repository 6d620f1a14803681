#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| asm_properties::check(bytes));
