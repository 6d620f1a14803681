use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};

/// Call without a timeout
///
/// A service may never answer. With a timeout, the caller receives an error and can continue.
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
#[code(C033, warning)]
#[error("missing timeout for calls of `{reference}`")]
pub(crate) struct NoTimeout {
    pub reference: String,
    pub default_ms: u64,
    pub at: Span,
}

impl Finding for NoTimeout {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        let applies = format!("defaults to {} ms", self.default_ms);
        diagnostic
            .label(self.at, applies)
            .help("add `timeout_ms = 2000`, or `oneway = true` if no reply is expected")
    }
}
