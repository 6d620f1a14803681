use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};

/// Bridge without a component
///
/// A bridge connects to ROS for the components `ros-bridge` that name it. Without one it has no effect.
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
/// [bridges.spare]
/// kind = "ros1"
/// master = "http://127.0.0.1:11312"
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
#[code(C171, warning)]
#[error("no component uses the bridge `{name}`")]
pub(crate) struct UnusedBridge {
    pub name: String,
    pub at: Span,
}

impl Finding for UnusedBridge {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        let Self { name, .. } = self;
        diagnostic.label(self.at, "has no effect").help(format!(
            "remove it, or add a component with `implementation = {{ builtin = \"ros-bridge\", bridge = \"{name}\" }}`"
        ))
    }
}
