//! Properties that hold for any bytes that nodes of ROS send. Each function takes bytes, and panics if its property is
//! violated; the fuzzers in `fuzz/wire` and the tests of `asmotion-robustness` call them.

#![allow(clippy::panic, reason = "a property fails by panicking")]

mod message;
mod ros1;

pub use message::{ros_definition, ros_message, ros2_message};
pub use ros1::{ros_header, xml_rpc};
