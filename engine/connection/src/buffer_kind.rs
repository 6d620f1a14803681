//! What is kept for a reader.

use serde::{Deserialize, Serialize};

/// What is kept for the reader.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum BufferKind {
    /// The newest sample (RTT DATA). What it replaces was not lost: it was out of date.
    Data,
    /// So many samples; when full, the new one is dropped and counted (RTT BUFFER).
    Buffer(usize),
    /// So many samples; when full, the oldest is dropped and counted (RTT CIRCULAR_BUFFER).
    Circular(usize),
}

impl BufferKind {
    /// How many samples are kept; a queue holds at least one.
    pub fn size(self) -> usize {
        match self {
            Self::Data => 1,
            Self::Buffer(size) | Self::Circular(size) => size.max(1),
        }
    }
}
