use crate::named::TypeAt;
use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};

/// Incompatible interfaces
///
/// A reference calls the operations of its interface, so the service at the other end must have the
/// same interface.
///
/// ```toml wrong
/// schema = "composite/1"
///
/// [composite]
/// name = "example"
///
/// [components.Map]
/// implementation = { rust = "nav::MapServer" }
/// services = { maps = "nav/MapService" }
///
/// [components.User]
/// implementation = { process = "user" }
/// references = { maps = "nav/PlanService" }
///
/// [[wires]]
/// reference = "User.maps"
/// service = "Map.maps"
/// timeout_ms = 1000
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
/// [components.Map]
/// implementation = { rust = "nav::MapServer" }
/// services = { maps = "nav/MapService" }
///
/// [components.User]
/// implementation = { process = "user" }
/// references = { maps = "nav/MapService" }
///
/// [[wires]]
/// reference = "User.maps"
/// service = "Map.maps"
/// timeout_ms = 1000
/// ```
#[derive(Debug, thiserror::Error, Coded)]
#[code(C030, error)]
#[error("incompatible interfaces: `{reference}` needs `{}`, but `{service}` provides `{}`", wanted.text, found.text)]
pub(crate) struct WireMismatch {
    pub reference: String,
    pub wanted: TypeAt,
    pub service: String,
    pub found: TypeAt,
    pub at: Span,
    pub reference_at: Span,
}

impl Finding for WireMismatch {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        let mut diagnostic = diagnostic
            .label(self.at, format!("provides `{}`", self.found.text))
            .label(self.reference_at, format!("needs `{}`", self.wanted.text));
        for place in [self.wanted.at, self.found.at].into_iter().flatten() {
            diagnostic = diagnostic.label(place, "declared here");
        }
        diagnostic.help("connect it to a service with that interface")
    }
}
