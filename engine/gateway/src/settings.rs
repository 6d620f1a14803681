//! Settings of a gateway.

use std::net::SocketAddr;
use std::time::Duration;

/// Address and limits of a gateway.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct GatewaySettings {
    /// Address to listen at; port 0 selects a free one.
    pub listen: SocketAddr,
    /// Limit on simultaneous connections; further ones wait (default: 64).
    pub max_connections: usize,
    /// Limit on the size of a request's body, in bytes (default: 1 MiB).
    pub max_body: usize,
    /// Limit on the time in which a request's header must arrive, and on the idle time of a connection (default: 10 s).
    pub request_timeout: Duration,
}

impl GatewaySettings {
    /// The default settings for this address.
    pub fn at(listen: SocketAddr) -> Self {
        Self {
            listen,
            max_connections: 64,
            max_body: 1 << 20,
            request_timeout: Duration::from_secs(10),
        }
    }
}
