use crate::nearest::Nearest;
use crate::nearest::Suggest;
use crate::wording::enumerate;
use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};

/// Unknown option
///
/// The key accepts a fixed set of words. The message lists them.
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
/// policy = { type = "data", lock = "lockfree" }
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
/// policy = { type = "data", lock = "lock_free" }
/// ```
#[derive(Debug, thiserror::Error, Coded)]
#[code(C006, error)]
#[error("invalid value `{word}` for `{key}`")]
pub(crate) struct UnknownOption {
    pub key: String,
    pub word: String,
    pub at: Span,
    pub known: Vec<&'static str>,
    pub nearest: Option<Nearest>,
}

impl Finding for UnknownOption {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        let Self { known, nearest, .. } = self;
        diagnostic
            .label(self.at, "not an option")
            .help(format!("write {}", enumerate(known)))
            .suggest(self.at, nearest)
    }
}
