use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};

/// Not a name in ROS
///
/// Topics and nodes of ROS have names of letters, digits and underscores, separated by slashes. A part does not begin with a
/// digit. A topic that begins with a slash is the same for all nodes; others are in the namespace of the node.
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
/// subscribe = { plan = "nav_msgs/Path" }
/// map = [
///   { from = "plan", ros = "/my plan", type = "nav_msgs/Path", direction = "to_ros" },
/// ]
///
/// [[promote]]
/// topic = "plan"
/// as = "plan"
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
/// subscribe = { plan = "nav_msgs/Path" }
/// map = [
///   { from = "plan", ros = "/my_plan", type = "nav_msgs/Path", direction = "to_ros" },
/// ]
///
/// [[promote]]
/// topic = "plan"
/// as = "plan"
/// ```
#[derive(Debug, thiserror::Error, Coded)]
#[code(C173, error)]
#[error("`{name}` is not a name in ROS")]
pub(crate) struct InvalidRosName {
    pub name: String,
    pub at: Span,
}

impl Finding for InvalidRosName {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        let help = if self.name.contains("__") {
            "separate words with one underscore: ROS 2 permits no more"
        } else {
            "use letters, digits, `_` and `/`, as in `/arm/joint_states`"
        };
        diagnostic
            .label(self.at, "a name in ROS is expected")
            .help(help)
    }
}
