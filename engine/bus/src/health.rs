//! The state of a transport, for those who must act when it is gone.

use std::fmt;
use std::sync::Arc;
use std::time::Instant;

/// The state of a bus' transport, and since when.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Health {
    /// The state.
    pub link: LinkState,
    /// Since when.
    pub since: Instant,
}

/// Whether messages go through.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum LinkState {
    /// They do.
    Up,
    /// What is published waits: the broker takes nothing. What others published before still comes in.
    Blocked {
        /// Why.
        reason: Arc<str>,
    },
    /// Nothing goes out or comes in.
    Down {
        /// Why.
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

    /// Whether messages go through.
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
