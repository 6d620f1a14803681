use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};

/// Invalid name
///
/// Names consist of letters, digits, `_` and `-`, and start with a letter. An endpoint of a connection
/// is written `Component.port` or `topic:name`.
///
/// ```toml wrong
/// schema = "composite/1"
///
/// [composite]
/// name = "example"
///
/// [components.Joystick]
/// implementation = { process = "joystick" }
/// ports.out = { twist = "geometry_msgs/Twist" }
///
/// [components.Rover]
/// implementation = { process = "rover" }
/// ports.in = { twist = "geometry_msgs/Twist" }
///
/// [[connections]]
/// from = "twist"
/// to = "Rover.twist"
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
/// [components.Joystick]
/// implementation = { process = "joystick" }
/// ports.out = { twist = "geometry_msgs/Twist" }
///
/// [components.Rover]
/// implementation = { process = "rover" }
/// ports.in = { twist = "geometry_msgs/Twist" }
///
/// [[connections]]
/// from = "Joystick.twist"
/// to = "Rover.twist"
/// ```
#[derive(Debug, thiserror::Error, Coded)]
#[code(C009, error)]
#[error("`{text}` is not valid as {what}")]
pub(crate) struct InvalidName {
    pub text: String,
    pub what: &'static str,
    pub rule: &'static str,
    pub at: Span,
}

impl Finding for InvalidName {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        diagnostic.label(self.at, "invalid form").help(self.rule)
    }
}
