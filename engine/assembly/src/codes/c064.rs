use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};

/// An address at which no gateway can listen
///
/// A gateway listens at an address of this machine and a port: `127.0.0.1:8080` for this machine alone, `0.0.0.0:8080` for
/// every network that it is in, port 0 for a free one.
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
/// Mended:
///
/// ```toml mended
/// schema = "composite/1"
///
/// [composite]
/// name = "example"
///
/// [gateways.main]
/// listen = "127.0.0.1:8080"
/// ```
///
/// It asks nobody who he is, and encrypts nothing: before one that a network reaches belongs a proxy that does.
#[derive(Debug, thiserror::Error, Coded)]
#[code(C064, error)]
#[error("gateway `{name}` cannot listen at `{text}`")]
pub(crate) struct InvalidAddress {
    pub name: String,
    pub text: String,
    pub at: Span,
}

impl Finding for InvalidAddress {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        diagnostic.label(self.at, "not an address and a port").help(
            "write `127.0.0.1:8080` for this machine alone, `0.0.0.0:8080` for every network, \
                     port 0 for a free one",
        )
    }
}
