use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};

/// File without a certificate
///
/// The key `ca` of a wire names a file with the certificates of the authorities that its server is trusted for, in the format PEM: each
/// between the lines `-----BEGIN CERTIFICATE-----` and `-----END CERTIFICATE-----`. The example names a file of another kind.
///
/// ```asm
/// asm example
/// signature:
/// definitions:
///   main rule r_Main = skip
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
/// url = "https://maps.example/services/maps"
/// ca = "example.asm"
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
/// timeout_ms = 3000
/// ```
#[derive(Debug, thiserror::Error, Coded)]
#[code(C190, error)]
#[error("`{path}` contains no certificate")]
pub(crate) struct NoCertificate {
    pub path: String,
    pub at: Span,
}

impl Finding for NoCertificate {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        diagnostic
            .label(self.at, "expected a file in the format PEM")
            .help("convert a certificate in the format DER with `openssl x509 -inform der -in FILE -out FILE.pem`")
    }
}
