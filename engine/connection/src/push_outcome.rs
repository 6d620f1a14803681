//! Outcome of sending a sample.

/// Outcome of sending a sample.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum PushOutcome {
    /// Stored for the reader.
    Stored,
    /// The new sample was dropped: the queue was full.
    DroppedNewest,
    /// Stored; an older sample was dropped for it.
    DroppedOldest,
}
