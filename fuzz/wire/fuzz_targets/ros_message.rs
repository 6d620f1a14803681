#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| asmotion_wire_robustness::ros_message(bytes));
