use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};

/// Queue without a size
///
/// A buffer has a fixed capacity. No default fits every system, so the composite must give it.
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
/// policy = { type = "buffer" }
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
/// policy = { type = "buffer", size = 8 }
/// ```
#[derive(Debug, thiserror::Error, Coded)]
#[code(C044, error)]
#[error("missing `size` for a connection of type `{kind}`")]
pub(crate) struct QueueWithoutSize {
    pub kind: &'static str,
    pub at: Span,
}

impl Finding for QueueWithoutSize {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        let Self { kind, .. } = self;
        diagnostic.label(self.at, "expected `size`").help(format!(
            "write `policy = {{ type = \"{kind}\", size = 16 }}`"
        ))
    }
}
