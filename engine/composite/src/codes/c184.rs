use asmotion_bridge::ConverterError;
use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};

/// Wrong converter of a field
///
/// A converter says what a field is here and in ROS: two units of one quantity, or pairs of values. Both sides must have the
/// field; units are for floating-point numbers, and the values here are strings.
///
/// ```toml wrong
/// schema = "composite/1"
///
/// [composite]
/// name = "example"
///
/// [bridges.ros]
/// kind = "ros1"
/// master = "http://127.0.0.1:11311"
///
/// [components.Bridge]
/// implementation = { builtin = "ros-bridge", bridge = "ros" }
/// subscribe = { state = "std_msgs/String" }
/// map = [
///   { from = "state", ros = "/state", type = "std_msgs/String", direction = "to_ros", convert = { data = "rad = deg" } },
/// ]
///
/// [[promote]]
/// topic = "state"
/// as = "state"
/// ```
///
/// Corrected:
///
/// ```toml corrected
/// schema = "composite/1"
///
/// [composite]
/// name = "example"
///
/// [bridges.ros]
/// kind = "ros1"
/// master = "http://127.0.0.1:11311"
///
/// [components.Bridge]
/// implementation = { builtin = "ros-bridge", bridge = "ros" }
/// subscribe = { state = "std_msgs/String" }
/// map = [
///   { from = "state", ros = "/state", type = "std_msgs/String", direction = "to_ros", convert = { data = "IDLE = stopped, MOVING = moving" } },
/// ]
///
/// [[promote]]
/// topic = "state"
/// as = "state"
/// ```
#[derive(Debug, thiserror::Error, Coded)]
#[code(C184, error)]
#[error("wrong converter: {reason}")]
pub(crate) struct WrongConverter {
    pub reason: ConverterError,
    pub at: Span,
}

impl Finding for WrongConverter {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        diagnostic
            .label(self.at, "the field cannot be converted like this")
            .help("write the unit or the value here first: `HERE = THERE`")
    }
}
