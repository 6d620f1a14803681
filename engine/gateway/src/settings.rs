//! Settings of a gateway.

use std::net::SocketAddr;
use std::time::Duration;

use asmotion_http::BearerToken;

/// Address and limits of a gateway.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct GatewaySettings {
    /// Address to listen at; port 0 selects a free one.
    pub listen: SocketAddr,
    /// Host names of the gateway, besides `localhost` and IP addresses: requests that address it by another name are rejected
    /// (default: none).
    pub allowed_hosts: Vec<String>,
    /// Token that every request must present; `None` if none is needed (default).
    pub token: Option<BearerToken>,
    /// Limit on simultaneous connections (default: 64). A further one replaces the connection that has been idle for the
    /// longest time; if calls are under way on all of them, it is rejected.
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
            allowed_hosts: Vec::new(),
            token: None,
            max_connections: 64,
            max_body: 1 << 20,
            request_timeout: Duration::from_secs(10),
        }
    }
}
