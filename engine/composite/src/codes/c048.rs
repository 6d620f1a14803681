use std::borrow::Cow;

use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};

/// Key without effect
///
/// The key has an effect only together with another key, for another kind of element, or where something uses it.
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
/// policy = { type = "data" }
/// ```
#[derive(Debug, thiserror::Error, Coded)]
#[code(C048, warning)]
#[error("`{key}` has no effect here")]
pub(crate) struct IdleKey {
    pub key: Cow<'static, str>,
    pub at: Span,
    pub reason: &'static str,
}

impl Finding for IdleKey {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        diagnostic.label(self.at, self.reason).help("remove it")
    }
}
