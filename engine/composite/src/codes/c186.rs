use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};

/// Component that ROS cannot see
///
/// A bridge shows components of its own composite to ROS: in ROS 2 as nodes, each with all properties and a name of its own; in
/// ROS 1 also single properties, as parameters with names of their own.
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
/// [components.MapServer]
/// implementation = { rust = "nav::MapServer" }
///
/// [components.Bridge]
/// implementation = { builtin = "ros-bridge", bridge = "ros" }
/// parameters = { MapServer = "maps", "MapServer.source" = "maps" }
/// map = []
///
/// [[promote]]
/// service = "MapServer.maps"
/// as = "maps"
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
/// [components.MapServer]
/// implementation = { rust = "nav::MapServer" }
///
/// [components.Bridge]
/// implementation = { builtin = "ros-bridge", bridge = "ros" }
/// parameters = { MapServer = "maps", "MapServer.source" = "/map_file" }
/// map = []
///
/// [[promote]]
/// service = "MapServer.maps"
/// as = "maps"
/// ```
#[derive(Debug, thiserror::Error, Coded)]
#[code(C186, error)]
#[error("`{name}` cannot be shown to ROS{}", reason.suffix())]
pub(crate) struct HiddenComponent {
    pub name: String,
    pub at: Span,
    pub reason: HiddenReason,
}

/// Why a component cannot be shown.
#[derive(Debug)]
pub(crate) enum HiddenReason {
    /// It is a composite.
    Nested,
    /// A single property has no life cycle.
    LifeCycleOfProperty,
    /// Parameters of ROS 2 belong to nodes.
    PropertyInRos2,
    /// The name in ROS is that of another component.
    Taken { other: String, before: Span },
}

impl HiddenReason {
    fn suffix(&self) -> String {
        match self {
            Self::Nested | Self::LifeCycleOfProperty | Self::PropertyInRos2 => String::new(),
            Self::Taken { other, .. } => format!(": `{other}` has the name"),
        }
    }
}

impl Finding for HiddenComponent {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        match &self.reason {
            HiddenReason::Nested => diagnostic
                .label(self.at, "is a composite")
                .help("add a ros-bridge to that composite, which shows its components"),
            HiddenReason::LifeCycleOfProperty => diagnostic
                .label(self.at, "a property has no life cycle")
                .help("name the component alone"),
            HiddenReason::PropertyInRos2 => diagnostic
                .label(self.at, "parameters of ROS 2 belong to nodes")
                .help("name the component alone: its node has a parameter for each property"),
            HiddenReason::Taken { before, .. } => diagnostic
                .label(self.at, "used again")
                .label(*before, "first used here")
                .help("choose another name"),
        }
    }
}
