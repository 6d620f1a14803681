use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};

/// Operation that a bridge does not map
///
/// ROS carries out the services of a bridge, so every operation of their interfaces is mapped to a service or an action of ROS.
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
/// services = { maps = "nav/MapService" }
/// map = []
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
/// services = { maps = "nav_msgs/GetMap" }
/// map = [
///   { from = "maps.call", ros = "/static_map", type = "nav_msgs/GetMap", direction = "to_ros" },
/// ]
/// ```
#[derive(Debug, thiserror::Error, Coded)]
#[code(C182, error)]
#[error("the bridge maps no operation `{operation}`")]
pub(crate) struct OperationNotMapped {
    pub operation: String,
    pub at: Span,
}

impl Finding for OperationNotMapped {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        let operation = &self.operation;
        diagnostic
            .label(self.at, "nobody carries it out")
            .help(format!(
                "add `{{ from = \"{operation}\", ros = …, type = …, direction = \"to_ros\" }}` to `map`"
            ))
    }
}
