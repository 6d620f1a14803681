//! Wires: how a reference is joined to a service.

use std::time::Duration;

use serde::{Deserialize, Serialize};

/// How a reference is joined to a service.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct Wire {
    /// How long one attempt may take.
    pub timeout: Duration,
    /// How often an attempt that got no answer is made again.
    pub retries: u32,
    /// The rest before it is made again the first time; each further one is twice as long.
    pub backoff: Duration,
    /// Whether the provider is told that an attempt timed out.
    pub cancel_on_timeout: bool,
    /// Whether calls have no reply at all (SCA `@OneWay`).
    pub one_way: bool,
}

impl Default for Wire {
    /// One attempt of one second; the provider is told when it times out.
    fn default() -> Self {
        Self {
            timeout: Duration::from_secs(1),
            retries: 0,
            backoff: Duration::ZERO,
            cancel_on_timeout: true,
            one_way: false,
        }
    }
}

impl Wire {
    /// One attempt of this length; the provider is told when it times out.
    pub fn timeout(timeout: Duration) -> Self {
        Self {
            timeout,
            ..Self::default()
        }
    }

    /// Without a reply.
    pub fn one_way() -> Self {
        Self {
            one_way: true,
            ..Self::default()
        }
    }

    /// With so many more attempts.
    #[must_use]
    pub fn retries(self, retries: u32) -> Self {
        Self { retries, ..self }
    }

    /// The rest after so many attempts.
    pub fn rest_after(&self, attempts: u32) -> Duration {
        let doublings = attempts.saturating_sub(1);
        self.backoff.saturating_mul(2_u32.saturating_pow(doublings))
    }
}
