use crate::check::DEFAULT_TIMEOUT_MS;
use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};

/// A call without a timeout
///
/// A service may never answer. With a timeout, the caller hears that and can go on.
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
/// Mended:
///
/// ```toml mended
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
#[error("nobody says how long a call of `{reference}` may take")]
pub(crate) struct NoTimeout {
    pub reference: String,
    pub at: Span,
}

impl Finding for NoTimeout {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        diagnostic
            .label(self.at, format!("{DEFAULT_TIMEOUT_MS} ms are taken"))
            .help("add `timeout_ms = 2000`, or `oneway = true` where no reply is awaited")
    }
}
