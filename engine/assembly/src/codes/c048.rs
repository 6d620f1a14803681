use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};

/// A key of a policy that says nothing
///
/// This key means something with another type of policy only.
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
/// to = "Rover.twist"
/// policy = { type = "data", size = 4 }
/// ```
///
/// Mended:
///
/// ```toml mended
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
/// policy = { type = "data" }
/// ```
#[derive(Debug, thiserror::Error, Coded)]
#[code(C048, warning)]
#[error("`{key}` says nothing here")]
pub(crate) struct IdleKey {
    pub key: &'static str,
    pub at: Span,
    pub reason: &'static str,
}

impl Finding for IdleKey {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        diagnostic.label(self.at, self.reason).help("leave it out")
    }
}
