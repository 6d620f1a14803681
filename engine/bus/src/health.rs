//! State of a transport, for callers that react to its loss.

use std::fmt;
use std::sync::Arc;
use std::time::Instant;

/// The state of a bus' transport, and since when.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Health {
    /// Current state.
    pub link: LinkState,
    /// Start of the current state.
    pub since: Instant,
}

/// State of the connection to the transport.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum LinkState {
    /// Messages flow in both directions.
    Up,
    /// Publishing is paused because the broker accepts nothing; messages still arrive.
    Blocked {
        /// Cause, in the broker's words.
        reason: Arc<str>,
    },
    /// No connection: nothing is sent or received.
    Down {
        /// Cause, for display.
        reason: Arc<str>,
    },
}

impl Health {
    /// A state that begins now.
    pub fn now(link: LinkState) -> Self {
        Self {
            link,
            since: Instant::now(),
        }
    }

    /// Returns whether messages flow in both directions.
    pub fn is_up(&self) -> bool {
        self.link == LinkState::Up
    }
}

impl fmt::Display for LinkState {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Up => f.write_str("up"),
            Self::Blocked { reason } => write!(f, "blocked: {reason}"),
            Self::Down { reason } => write!(f, "down: {reason}"),
        }
    }
}
