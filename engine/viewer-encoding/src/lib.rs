//! Messages as viewers such as Foxglove, Lichtblick and PlotJuggler read them, in a recording and over a WebSocket.
//!
//! A channel has messages of one type. If ROS 2 has a type of this name with the same fields, they are in CDR and described by its
//! definition, so that viewers draw them; all other messages are JSON with a JSON Schema.

mod channel_schema;
mod encoding_names;
mod ros_type;

pub use channel_schema::ChannelSchema;
pub use encoding_names::{CDR, JSON, JSON_SCHEMA, ROS2_DEFINITION};
pub use ros_type::RosType;
