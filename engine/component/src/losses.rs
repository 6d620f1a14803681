//! Losses: messages that did not reach a component's work.

use serde::{Deserialize, Serialize};

/// Messages that came to a component, and not to its work.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
pub struct Losses {
    /// Dropped because too many waited.
    pub dropped: u64,
    /// Left out because they did not fit their purpose.
    pub misfits: u64,
}
