use crate::nearest::{Nearest, Suggest};
use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};

/// Service of ROS that no bridge maps
///
/// A wire to `ros:/NAME` leads to the service of the bridge whose `map` joins it with this service or action of ROS. If several
/// bridges do, name the component and its service.
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
/// [components.Client]
/// implementation = { process = "client" }
/// references = { maps = "nav_msgs/GetMap" }
///
/// [components.Bridge]
/// implementation = { builtin = "ros-bridge", bridge = "ros" }
/// services = { maps = "nav_msgs/GetMap" }
/// map = [
///   { from = "maps.call", ros = "/static_map", type = "nav_msgs/GetMap", direction = "to_ros" },
/// ]
///
/// [[wires]]
/// reference = "Client.maps"
/// service = "ros:/map"
/// timeout_ms = 1000
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
/// [components.Client]
/// implementation = { process = "client" }
/// references = { maps = "nav_msgs/GetMap" }
///
/// [components.Bridge]
/// implementation = { builtin = "ros-bridge", bridge = "ros" }
/// services = { maps = "nav_msgs/GetMap" }
/// map = [
///   { from = "maps.call", ros = "/static_map", type = "nav_msgs/GetMap", direction = "to_ros" },
/// ]
///
/// [[wires]]
/// reference = "Client.maps"
/// service = "ros:/static_map"
/// timeout_ms = 1000
/// ```
#[derive(Debug, thiserror::Error, Coded)]
#[code(C185, error)]
#[error("{} `{ros}` of ROS", if services.is_empty() { "no bridge maps" } else { "several bridges map" })]
pub(crate) struct NoSingleRosService {
    pub ros: String,
    /// The services of bridges that lead to it.
    pub services: Vec<String>,
    pub nearest: Option<Nearest>,
    pub at: Span,
}

impl Finding for NoSingleRosService {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        if let Some(first) = self.services.first() {
            return diagnostic
                .label(self.at, "ambiguous")
                .help(format!("name the service, as in `service = \"{first}\"`"));
        }
        diagnostic.label(self.at, "not mapped `to_ros`").suggest_or(
            self.at,
            &self.nearest,
            "add an entry to the `map` of a ros-bridge",
        )
    }
}
