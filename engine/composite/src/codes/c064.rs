use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};

/// Invalid gateway address
///
/// A gateway listens at an address of this machine and a port: `127.0.0.1:8080` for local clients only,
/// `0.0.0.0:8080` for all network interfaces. Port 0 picks a free port.
///
/// ```toml wrong
/// schema = "composite/1"
///
/// [composite]
/// name = "example"
///
/// [gateways.main]
/// listen = "http://localhost:8080"
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
/// [gateways.main]
/// listen = "127.0.0.1:8080"
/// ```
///
/// A gateway does not encrypt. Give one that is reachable from a network a `token`, and put a proxy that
/// encrypts in front of it.
#[derive(Debug, thiserror::Error, Coded)]
#[code(C064, error)]
#[error("invalid address `{text}` of gateway `{name}`")]
pub(crate) struct InvalidAddress {
    pub name: String,
    pub text: String,
    pub at: Span,
}

impl Finding for InvalidAddress {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        diagnostic.label(self.at, "not an IP address and a port").help(
            "write `127.0.0.1:8080` for this machine only, or `0.0.0.0:8080` for all networks; port 0 selects a free port",
        )
    }
}
