use crate::nearest::{Nearest, Suggest};
use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};

/// Nothing to leave out
///
/// `without` names an element that the base does not have. A path consists of the names of keys, separated by dots. A
/// connection, wire or promotion is named by one of its ends, or by both: `connections.Joystick.twist -> Rover.twist`.
///
/// ```toml base
/// schema = "composite/1"
///
/// [composite]
/// name = "base"
///
/// [components.Joystick]
/// implementation = { rust = "nav::Operator" }
///
/// [components.Maps]
/// implementation = { rust = "nav::MapServer" }
/// ```
///
/// ```toml wrong
/// schema = "composite/1"
/// base = "base.toml"
/// without = ["components.Joystik"]
/// ```
///
/// Corrected:
///
/// ```toml corrected
/// schema = "composite/1"
/// base = "base.toml"
/// without = ["components.Joystick"]
/// ```
#[derive(Debug, thiserror::Error, Coded)]
#[code(C129, error)]
#[error("`{base}` has no `{path}`")]
pub(crate) struct NothingToLeaveOut {
    pub path: String,
    pub at: Span,
    pub base: String,
    pub nearest: Option<Nearest>,
}

impl Finding for NothingToLeaveOut {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        let way_out = "name the keys that lead to it, separated by dots".to_owned();
        diagnostic
            .label(self.at, "not in the base")
            .suggest_or(self.at, &self.nearest, way_out)
    }
}
