use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};
use std::net::SocketAddr;

/// Duplicate gateway address
///
/// Only one gateway can listen at an address.
///
/// ```toml wrong
/// schema = "composite/1"
///
/// [composite]
/// name = "example"
///
/// [gateways.main]
/// listen = "127.0.0.1:8080"
///
/// [gateways.other]
/// listen = "127.0.0.1:8080"
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
///
/// [gateways.other]
/// listen = "127.0.0.1:8081"
/// ```
#[derive(Debug, thiserror::Error, Coded)]
#[code(C065, error)]
#[error("duplicate gateway address {address}")]
pub(crate) struct DuplicateAddress {
    pub address: SocketAddr,
    pub at: Span,
    pub first: Span,
}

impl Finding for DuplicateAddress {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        diagnostic
            .label(self.at, "used again here")
            .label(self.first, "first used here")
            .help("change one port, or promote everything through one gateway")
    }
}
