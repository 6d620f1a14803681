//! Kinds of buffer between a writer and a reader.

use serde::{Deserialize, Serialize};

/// Kind of buffer between a writer and a reader.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum BufferKind {
    /// The newest sample (RTT DATA). A sample that is replaced does not count as lost: it was out of date.
    Data,
    /// A queue of this capacity; when full, the new sample is dropped and counted (RTT BUFFER).
    Buffer(usize),
    /// A queue of this capacity; when full, the oldest sample is dropped and counted (RTT CIRCULAR_BUFFER).
    Circular(usize),
}

impl BufferKind {
    /// Returns the capacity in samples; a queue holds at least one.
    pub fn size(self) -> usize {
        match self {
            Self::Data => 1,
            Self::Buffer(size) | Self::Circular(size) => size.max(1),
        }
    }
}
