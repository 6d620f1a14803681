use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};

/// Token sent without encryption
///
/// Calls over `http://` are not encrypted. Every program that can listen to the network between this machine and the service
/// reads the token of the wire, and can call the service with it.
///
/// ```toml wrong
/// schema = "composite/1"
///
/// [composite]
/// name = "example"
///
/// [components.User]
/// implementation = { process = "user" }
/// references = { maps = "nav/MapService" }
///
/// [[wires]]
/// reference = "User.maps"
/// binding = "http"
/// url = "http://maps.example/services/maps"
/// token = "${MAPS_TOKEN:-none}"
/// timeout_ms = 500
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
/// [components.User]
/// implementation = { process = "user" }
/// references = { maps = "nav/MapService" }
///
/// [[wires]]
/// reference = "User.maps"
/// binding = "http"
/// url = "https://maps.example/services/maps"
/// token = "${MAPS_TOKEN:-none}"
/// timeout_ms = 500
/// ```
///
/// `http://` to this machine, `127.0.0.1`, is no finding: a gateway listens there behind a proxy that encrypts.
#[derive(Debug, thiserror::Error, Coded)]
#[code(C152, warning)]
#[error("the token of `{reference}` is sent to `{host}` without encryption")]
pub(crate) struct TokenInClear {
    pub reference: String,
    pub host: String,
    pub at: Span,
    /// Location of the URL.
    pub url: Span,
}

impl Finding for TokenInClear {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        diagnostic
            .label(self.at, "sent with each call")
            .label(self.url, "not encrypted")
            .help("call the service over `https://`")
    }
}
