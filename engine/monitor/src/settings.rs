//! Settings of a dashboard.

use std::net::SocketAddr;
use std::time::Duration;

use asmotion_http::BearerToken;
use rand::TryRng;
use rand::rngs::SysRng;

/// The operating system gives no random numbers.
#[derive(Debug, thiserror::Error)]
#[error("no random numbers for a token: {0}")]
pub struct RandomError(String);

/// Address and limits of a dashboard.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct DashboardSettings {
    /// Address to listen at, on a loopback interface; port 0 selects a free one.
    pub listen: SocketAddr,
    /// Whether a free port takes the place of that of the address if it is in use (default: no).
    pub or_free_port: bool,
    /// Token that a tab must present before it may control the system; `None` if no tab may (default).
    pub control: Option<BearerToken>,
    /// Pages besides those of this server that may read over the protocol of Foxglove, as origins such as
    /// `https://app.foxglove.dev` (default: none). Programs that are no web pages send no origin and need no permission.
    pub allowed_origins: Vec<String>,
    /// Limit on simultaneous connections, of which each open tab needs one (default: 64).
    pub max_connections: usize,
    /// Limit on the size of a message of a tab, in bytes (default: 64 KiB).
    pub max_message: usize,
    /// Limit on the outputs to which a tab may subscribe (default: 64).
    pub max_subscriptions: usize,
    /// Limit on the channels to which a viewer such as Foxglove may subscribe (default: 512).
    pub max_channels: usize,
    /// Time without a command after which a tab is no longer armed (default: 5 min).
    pub armed_for: Duration,
}

impl DashboardSettings {
    /// The default settings for this address.
    pub fn at(listen: SocketAddr) -> Self {
        Self {
            listen,
            or_free_port: false,
            control: None,
            allowed_origins: Vec::new(),
            max_connections: 64,
            max_message: 64 * 1024,
            max_subscriptions: 64,
            max_channels: 512,
            armed_for: Duration::from_secs(300),
        }
    }

    /// A new token: 128 random bits.
    ///
    /// # Errors
    /// The operating system gives no random numbers.
    pub fn new_token() -> Result<String, RandomError> {
        let mut bits = [0; 16];
        SysRng
            .try_fill_bytes(&mut bits)
            .map_err(|error| RandomError(error.to_string()))?;
        Ok(bits.iter().map(|byte| format!("{byte:02x}")).collect())
    }
}
