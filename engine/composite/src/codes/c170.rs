use crate::nearest::{Nearest, Suggest};
use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};

/// Unknown message type of ROS
///
/// The type of a mapped topic is a message of the generation of ROS that the bridge connects to.
/// `asmotion ros types` lists them. Further ones come from the folders that the bridge names in `definitions`.
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
///   { from = "plan", ros = "/trajectory", type = "nav_msgs/Pathe", direction = "to_ros" },
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
///   { from = "plan", ros = "/trajectory", type = "nav_msgs/Path", direction = "to_ros" },
/// ]
///
/// [[promote]]
/// topic = "plan"
/// as = "plan"
/// ```
#[derive(Debug, thiserror::Error, Coded)]
#[code(C170, error)]
#[error("unknown message type `{name}` of {generation}")]
pub(crate) struct UnknownRosType {
    pub name: String,
    pub generation: &'static str,
    pub at: Span,
    /// Why a type that has a definition cannot be used.
    pub problem: Option<String>,
    pub nearest: Option<Nearest>,
}

impl Finding for UnknownRosType {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        if let Some(problem) = &self.problem {
            return diagnostic
                .label(self.at, "its definition cannot be used")
                .note(problem.clone());
        }
        diagnostic
            .label(self.at, "not among the message types of this build")
            .suggest_or(
                self.at,
                &self.nearest,
                "`asmotion ros types` lists the message types; the key `definitions` of the bridge names folders with others",
            )
    }
}
