use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};

/// Reference wired or promoted twice
///
/// A call goes to one service. To call several services separately, declare a reference for each. Several wires of a reference
/// are alternatives, of which a call uses the first one that is available; each has one service and another `binding`.
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
/// references = { maps = "nav/MapService" }
///
/// [[wires]]
/// reference = "User.maps"
/// service = "Map.maps"
/// timeout_ms = 1000
///
/// [[wires]]
/// reference = "User.maps"
/// service = "Map.maps"
/// timeout_ms = 200
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
#[code(C032, error)]
#[error("reference `{reference}` is {how}")]
pub(crate) struct ReferenceWiredTwice {
    pub reference: String,
    pub how: &'static str,
    pub at: Span,
    pub first: Span,
}

impl Finding for ReferenceWiredTwice {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        diagnostic
            .label(self.at, "connected again here")
            .label(self.first, "first connected here")
            .help(match self.how {
                WIRED_TWICE => "for one-way calls to several services, list them in one wire: `service = [\"A.x\", \"B.x\"]`; for alternatives, give each wire another `binding`",
                _ => "remove one of them",
            })
    }
}

/// Reason if two wires share a reference.
pub(crate) const WIRED_TWICE: &str = "wired twice";
