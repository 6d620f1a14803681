//! Capacity of a queue.

/// The capacity of a queue.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct QueueCapacity {
    /// Number of messages.
    pub messages: usize,
    /// Size of the largest message, in bytes (RTT `data_size`).
    pub size: usize,
}
