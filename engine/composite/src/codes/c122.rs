use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};

/// Mapped topic not listed
///
/// A bridge maps only topics that it lists under `subscribe` or `publish`.
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
///   { from = "scan", ros = "/trajectory", type = "nav_msgs/Path", direction = "to_ros" },
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
#[code(C122, error)]
#[error("`{name}` goes {direction}, so it must be listed under `{list}`")]
pub(crate) struct PortNotListed {
    pub name: String,
    pub direction: &'static str,
    pub list: &'static str,
    pub kind: String,
    pub at: Span,
}

impl Finding for PortNotListed {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        let Self {
            name, list, kind, ..
        } = self;
        diagnostic
            .label(self.at, format!("not listed under `{list}`"))
            .help(format!("add `{list} = {{ {name} = \"{kind}\" }}`"))
    }
}
