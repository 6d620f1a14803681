use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};

/// Duplicate connection
///
/// A second connection between the same two ends would deliver every message twice.
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
/// from = "Joystick.twist"
/// to = ["Rover.twist", "Rover.twist"]
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
#[code(C049, error)]
#[error("duplicate connection of `{from}` and `{to}`")]
pub(crate) struct DuplicateConnection {
    pub from: String,
    pub to: String,
    pub at: Span,
    pub first: Span,
}

impl Finding for DuplicateConnection {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        diagnostic
            .label(self.at, "connected again here")
            .label(self.first, "first connected here")
            .help("remove one of them")
    }
}
