use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};

/// Mapped topic of another type
///
/// A topic and its ROS topic must have the same type: equal names and fields. The sequence number that headers have in ROS 1
/// only does not count.
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
///   { from = "plan", ros = "/trajectory", type = "std_msgs/String", direction = "to_ros" },
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
#[code(C123, error)]
#[error("mismatched types: `{name}` is `{here}` here and `{there}` there")]
pub(crate) struct PortTypeDiffers {
    pub name: String,
    pub here: String,
    pub there: String,
    pub at: Span,
    pub declared: Option<Span>,
    /// The first difference and both definitions; `None` if a type is unknown.
    pub definitions: Option<RosDifference>,
}

/// A difference between a type of the composite and one of ROS.
#[derive(Debug)]
pub(crate) struct RosDifference {
    pub difference: String,
    pub here: String,
    pub there: String,
}

impl Finding for PortTypeDiffers {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        let Self {
            declared,
            here,
            there,
            ..
        } = self;
        let diagnostic = diagnostic.label(self.at, "type there");
        let diagnostic = match declared {
            Some(declared) => diagnostic.label(*declared, "type here"),
            None => diagnostic,
        };
        let diagnostic = match &self.definitions {
            Some(of) => diagnostic
                .note(&of.difference)
                .note(format!("`{here}` here:\n{}", of.here.trim_end()))
                .note(format!("`{there}` there:\n{}", of.there.trim_end())),
            None => diagnostic,
        };
        diagnostic.help("use one type on both sides")
    }
}
