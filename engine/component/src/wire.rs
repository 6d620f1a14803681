//! Wires between references and services.

use std::time::Duration;

use serde::{Deserialize, Serialize};

/// The wire between a reference and a service: timing and kind of its calls.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct Wire {
    /// Limit on the duration of one attempt (default: 1 s).
    pub timeout: Duration,
    /// Number of further attempts after one without a reply (default: 0).
    pub retries: u32,
    /// Pause before the first retry; doubles for each further one (default: 0).
    pub backoff: Duration,
    /// Whether the provider is notified when an attempt times out (default: `true`).
    pub cancel_on_timeout: bool,
    /// Whether calls have no reply at all (SCA `@OneWay`; default: `false`).
    pub one_way: bool,
    /// Position among the alternatives of the reference: a call goes to the first one that is available (default: 0).
    pub alternative: u32,
}

impl Default for Wire {
    /// One attempt of one second; a timeout cancels it at the provider.
    fn default() -> Self {
        Self {
            timeout: Duration::from_secs(1),
            retries: 0,
            backoff: Duration::ZERO,
            cancel_on_timeout: true,
            one_way: false,
            alternative: 0,
        }
    }
}

impl Wire {
    /// One attempt with this timeout; a timeout cancels it at the provider.
    pub fn timeout(timeout: Duration) -> Self {
        Self {
            timeout,
            ..Self::default()
        }
    }

    /// Calls without a reply.
    pub fn one_way() -> Self {
        Self {
            one_way: true,
            ..Self::default()
        }
    }

    /// Sets the number of further attempts.
    #[must_use]
    pub fn retries(self, retries: u32) -> Self {
        Self { retries, ..self }
    }

    /// Sets the position among the alternatives of the reference.
    #[must_use]
    pub fn alternative(self, alternative: u32) -> Self {
        Self {
            alternative,
            ..self
        }
    }

    /// The pause after this many attempts.
    pub fn retry_delay(&self, attempts: u32) -> Duration {
        let doublings = attempts.saturating_sub(1);
        self.backoff.saturating_mul(2_u32.saturating_pow(doublings))
    }
}
