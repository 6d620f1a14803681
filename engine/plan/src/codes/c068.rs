use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};

/// Invalid URL of a service
///
/// A wire over HTTP leads to the URL of a service, `http://HOST:PORT/PATH` or `https://HOST/PATH`. A call of the operation
/// `getMap` is a `POST` to this URL followed by `/getMap`. A wire over a broker leads to a service of another robot on the same
/// broker, `robot://ROBOT/Component.service`.
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
/// url = "maps.example/services/maps"
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
/// timeout_ms = 500
/// ```
#[derive(Debug, thiserror::Error, Coded)]
#[code(C068, error)]
#[error("invalid URL `{text}` of a service")]
pub(crate) struct InvalidServiceUrl {
    pub text: String,
    pub reason: &'static str,
    /// A correct URL.
    pub example: &'static str,
    pub at: Span,
}

impl Finding for InvalidServiceUrl {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        diagnostic
            .label(self.at, self.reason)
            .help(format!("write it as in `{}`", self.example))
    }
}
