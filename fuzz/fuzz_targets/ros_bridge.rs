#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| asmotion_robustness::ros_bridge(bytes));
