use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};

/// Certificate authority of a wire without encryption
///
/// The key `ca` says which authorities are trusted for the certificate of a server. A server whose URL begins with `http://` shows no
/// certificate: nothing is encrypted, and any server that answers at its address is believed.
///
/// ```pem
/// -----BEGIN CERTIFICATE-----
/// MIIBejCCASGgAwIBAgIU
/// -----END CERTIFICATE-----
/// ```
///
/// ```toml wrong
/// schema = "composite/1"
///
/// [composite]
/// name = "example"
///
/// [components.Client]
/// implementation = { process = "client" }
/// references = { maps = "nav/MapService" }
///
/// [[wires]]
/// reference = "Client.maps"
/// binding = "http"
/// url = "http://maps.example/services/maps"
/// ca = "plant-ca.pem"
/// timeout_ms = 3000
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
/// [components.Client]
/// implementation = { process = "client" }
/// references = { maps = "nav/MapService" }
///
/// [[wires]]
/// reference = "Client.maps"
/// binding = "http"
/// url = "https://maps.example/services/maps"
/// ca = "plant-ca.pem"
/// timeout_ms = 3000
/// ```
#[derive(Debug, thiserror::Error, Coded)]
#[code(C191, error)]
#[error("`{reference}` has a certificate authority, but its calls are not encrypted")]
pub(crate) struct AuthorityWithoutTls {
    pub reference: String,
    pub at: Span,
    pub url: Span,
}

impl Finding for AuthorityWithoutTls {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        diagnostic
            .label(self.at, "has no effect")
            .label(self.url, "not encrypted")
            .help("write a URL that begins with `https://`, or remove `ca`")
    }
}
