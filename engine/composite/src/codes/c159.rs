use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};

/// Component of another robot not verified
///
/// A component of the composite stands for one of another robot (`builtin = "remote"`), which announces its ports and services on
/// the broker. Without a connection to the broker, neither these nor the connections, wires and proxies that use them are
/// verified. `asmotion run` asks the robot before the start.
///
/// ```toml wrong
/// schema = "composite/1"
///
/// [composite]
/// name = "example"
///
/// [components.Arm]
/// implementation = { builtin = "remote", target = "robot://arm/Driver" }
/// ```
///
/// Corrected, if the driver runs in this system:
///
/// ```toml corrected
/// schema = "composite/1"
///
/// [composite]
/// name = "example"
///
/// [components.Arm]
/// implementation = { rust = "youbot::DummyDriver" }
/// ```
#[derive(Debug, thiserror::Error, Coded)]
#[code(C159, warning)]
#[error("`{target}` is not verified: its robot was not asked")]
pub(crate) struct RobotNotAsked {
    /// Address of the component.
    pub target: String,
    pub at: Span,
    /// The members of the component that the composite lists.
    pub unverified: Vec<String>,
}

impl Finding for RobotNotAsked {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        let diagnostic = diagnostic.label(self.at, "component of another robot");
        let diagnostic = if self.unverified.is_empty() {
            diagnostic
        } else {
            diagnostic.note(format!("not verified: {}", self.unverified.join(", ")))
        };
        diagnostic.help("`asmotion run` asks it over the broker before anything starts; its ports and services are those that it announces then")
    }
}
