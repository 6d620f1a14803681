//! Counts of messages that a component received but did not use.

use serde::{Deserialize, Serialize};

/// Messages that a component received but did not use.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
pub struct Losses {
    /// Dropped because a queue was full.
    pub dropped: u64,
    /// Ignored because their content was unsuitable.
    pub misfits: u64,
}
