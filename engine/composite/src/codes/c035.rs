use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};

/// Circular masters
///
/// A component with a `master` cycles in the master's thread, right after it. A circle of masters has
/// no first component.
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
/// activity = { master = "Rover" }
///
/// [components.Rover]
/// implementation = { process = "rover" }
/// ports.in = { twist = "geometry_msgs/Twist" }
/// activity = { master = "Joystick" }
///
/// [[connections]]
/// from = "Joystick.twist"
/// to = "Rover.twist"
/// policy = { type = "data" }
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
/// activity = { period_ms = 20 }
///
/// [components.Rover]
/// implementation = { process = "rover" }
/// ports.in = { twist = "geometry_msgs/Twist" }
/// activity = { master = "Joystick" }
///
/// [[connections]]
/// from = "Joystick.twist"
/// to = "Rover.twist"
/// policy = { type = "data" }
/// ```
#[derive(Debug, thiserror::Error, Coded)]
#[code(C035, error)]
#[error("`{component}` cannot run after itself")]
pub(crate) struct MasterCycle {
    pub component: String,
    pub at: Span,
}

impl Finding for MasterCycle {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        diagnostic
            .label(self.at, "leads back to it")
            .help("remove `master` from one of them: it drives the others")
    }
}
