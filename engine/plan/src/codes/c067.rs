use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};
use std::net::SocketAddr;

/// Gateway open to the network
///
/// The gateway listens at an address that other machines can reach, and has no token: every program on the network can call the
/// promoted services, and so can command the robot.
///
/// ```toml wrong
/// schema = "composite/1"
///
/// [composite]
/// name = "example"
///
/// [gateways.main]
/// listen = "0.0.0.0:8080"
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
/// listen = "0.0.0.0:8080"
/// token = "${GATEWAY_TOKEN_FILE}"
/// ```
///
/// A gateway does not encrypt: on a network that others can listen to, let it listen at `127.0.0.1` behind a proxy that does.
#[derive(Debug, thiserror::Error, Coded)]
#[code(C067, warning)]
#[error("the gateway at {address} is open to every program on the network")]
pub(crate) struct OpenGateway {
    pub address: SocketAddr,
    pub at: Span,
}

impl Finding for OpenGateway {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        diagnostic
            .label(self.at, "reachable from other machines, without a token")
            .help("add `token = \"${GATEWAY_TOKEN_FILE}\"`, or listen at `127.0.0.1` for this machine only")
    }
}
