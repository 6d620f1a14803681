use crate::named::TypeAt;
use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};

/// Incompatible message types
///
/// Both ends of a connection must have the same message type.
///
/// ```toml wrong
/// schema = "composite/1"
///
/// [composite]
/// name = "example"
///
/// [components.Joystick]
/// implementation = { process = "joystick" }
/// ports.out = { twist = "nav_msgs/Path" }
///
/// [components.Rover]
/// implementation = { process = "rover" }
/// ports.in = { twist = "geometry_msgs/Twist" }
///
/// [[connections]]
/// from = "Joystick.twist"
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
#[code(C042, error)]
#[error("mismatched types: `{from}` is `{}`, but `{to}` is `{}`", from_kind.text, to_kind.text)]
pub(crate) struct ConnectionMismatch {
    pub from: String,
    pub from_kind: TypeAt,
    pub from_at: Span,
    pub to: String,
    pub to_kind: TypeAt,
    pub to_at: Span,
}

impl Finding for ConnectionMismatch {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        let mut diagnostic = diagnostic
            .label(self.to_at, format!("takes `{}`", self.to_kind.text))
            .label(self.from_at, format!("provides `{}`", self.from_kind.text))
            .help("connect ports of one type, or convert the message with a component in between");
        for place in [self.from_kind.at, self.to_kind.at].into_iter().flatten() {
            diagnostic = diagnostic.label(place, "declared here");
        }
        diagnostic
    }
}
