//! The names of encodings in MCAP and in the protocol of Foxglove.

/// Name of the encoding of messages of ROS 2.
pub const CDR: &str = "cdr";
/// Name of the encoding of their definitions.
pub const ROS2_DEFINITION: &str = "ros2msg";
/// Name of the encoding of all other messages.
pub const JSON: &str = "json";
/// Name of the encoding of their definitions.
pub const JSON_SCHEMA: &str = "jsonschema";
