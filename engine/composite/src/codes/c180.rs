use crate::nearest::{Nearest, Suggest};
use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};

/// Unknown service or action of ROS
///
/// An operation of a bridge, such as `maps.getMap`, is mapped to a service or an action of the generation of ROS that the bridge
/// connects to. `asmotion ros types` lists them. Where both have one short name, `nav_msgs/action/GetMap` is the action.
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
///   { from = "maps.call", ros = "/static_map", type = "nav_msgs/GetMapp", direction = "to_ros" },
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
/// services = { maps = "nav_msgs/GetMap" }
/// map = [
///   { from = "maps.call", ros = "/static_map", type = "nav_msgs/GetMap", direction = "to_ros" },
/// ]
/// ```
#[derive(Debug, thiserror::Error, Coded)]
#[code(C180, error)]
#[error("unknown service or action `{name}` of {generation}")]
pub(crate) struct UnknownRosOperation {
    pub name: String,
    pub generation: &'static str,
    pub at: Span,
    /// Why a service or an action that has a definition cannot be used.
    pub problem: Option<String>,
    pub nearest: Option<Nearest>,
}

impl Finding for UnknownRosOperation {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        if let Some(problem) = &self.problem {
            return diagnostic
                .label(self.at, "its definition cannot be used")
                .note(problem.clone());
        }
        diagnostic
            .label(self.at, "not among the services and actions of this build")
            .suggest_or(
                self.at,
                &self.nearest,
                "`asmotion ros types` lists services and actions; the key `definitions` of the bridge names folders with others",
            )
    }
}
