//! The front door: the `asmotion` binary.

fn main() {}
