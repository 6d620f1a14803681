use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};

/// ROS topic mapped twice
///
/// A node publishes a topic of ROS once, with one sequence of messages. Several topics of the composite cannot go to
/// the same topic of ROS through one bridge.
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
/// subscribe = { plan = "nav_msgs/Path", detour = "nav_msgs/Path" }
/// map = [
///   { from = "plan", ros = "/trajectory", type = "nav_msgs/Path", direction = "to_ros" },
///   { from = "detour", ros = "/trajectory", type = "nav_msgs/Path", direction = "to_ros" },
/// ]
///
/// [[promote]]
/// topic = "plan"
/// as = "plan"
///
/// [[promote]]
/// topic = "detour"
/// as = "detour"
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
/// subscribe = { plan = "nav_msgs/Path", detour = "nav_msgs/Path" }
/// map = [
///   { from = "plan", ros = "/trajectory", type = "nav_msgs/Path", direction = "to_ros" },
///   { from = "detour", ros = "/detour", type = "nav_msgs/Path", direction = "to_ros" },
/// ]
///
/// [[promote]]
/// topic = "plan"
/// as = "plan"
///
/// [[promote]]
/// topic = "detour"
/// as = "detour"
/// ```
#[derive(Debug, thiserror::Error, Coded)]
#[code(C172, error)]
#[error("`{ros}` is mapped twice, from `{first}` and from `{second}`")]
pub(crate) struct MappedTwice {
    pub ros: String,
    pub first: String,
    pub second: String,
    pub at: Span,
    pub before: Span,
}

impl Finding for MappedTwice {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        diagnostic
            .label(self.at, "mapped again")
            .label(self.before, "first mapped here")
            .help("map each topic to a topic of ROS of its own, or publish both to one topic of the composite")
    }
}
