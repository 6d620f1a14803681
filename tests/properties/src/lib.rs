//! Properties that hold for any input of the readers of files and messages. Each function takes bytes, and panics if
//! its property is violated; the fuzzers in `fuzz/` and the tests of this crate call them.

#![allow(clippy::panic, reason = "a property fails by panicking")]

mod composite;
mod message;
mod place;
mod ros_bridge;
mod xml;

pub use composite::{composite, property_file};
pub use message::{cbor, cdr, json, queue};
pub use place::{osm, osm_pbf};
pub use ros_bridge::ros_bridge;
pub use xml::{cpf, scdl};
