use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};

/// Operation mapped twice
///
/// One service or action of ROS carries out an operation, and one operation carries out a service or an action that is offered to
/// ROS.
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
/// services = { maps = "nav_msgs/GetMap" }
/// map = [
///   { from = "maps.call", ros = "/static_map", type = "nav_msgs/GetMap", direction = "to_ros" },
///   { from = "maps.call", ros = "/dynamic_map", type = "nav_msgs/GetMap", direction = "to_ros" },
/// ]
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
/// services = { maps = "nav_msgs/GetMap", dynamic = "nav_msgs/GetMap" }
/// map = [
///   { from = "maps.call", ros = "/static_map", type = "nav_msgs/GetMap", direction = "to_ros" },
///   { from = "dynamic.call", ros = "/dynamic_map", type = "nav_msgs/GetMap", direction = "to_ros" },
/// ]
/// ```
#[derive(Debug, thiserror::Error, Coded)]
#[code(C183, error)]
#[error("`{name}` is mapped twice")]
pub(crate) struct OperationMappedTwice {
    /// The operation, or the service or action of ROS.
    pub name: String,
    pub at: Span,
    pub before: Span,
}

impl Finding for OperationMappedTwice {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        diagnostic
            .label(self.at, "mapped again")
            .label(self.before, "first mapped here")
            .help("remove one of them, or list a second service or reference")
    }
}
