use crate::nearest::Nearest;
use crate::nearest::Suggest;
use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};

/// Type not in this build
///
/// The fields of this type are unknown, so they cannot be checked. Describe the type in a type file.
///
/// ```toml wrong
/// schema = "composite/1"
///
/// [composite]
/// name = "example"
///
/// [components.Joystick]
/// implementation = { process = "joystick" }
/// ports.out = { twist = "acme/Stick" }
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
/// ```
#[derive(Debug, thiserror::Error, Coded)]
#[code(C114, warning)]
#[error("type `{name}` is not in this build")]
pub(crate) struct TypeNotInBuild {
    pub name: String,
    pub at: Span,
    pub nearest: Option<Nearest>,
}

impl Finding for TypeNotInBuild {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        let Self { nearest, .. } = self;
        diagnostic
            .label(self.at, "its fields cannot be checked")
            .help("describe it in a file under `composite.types`")
            .suggest(self.at, nearest)
    }
}
