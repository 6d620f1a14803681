//! A running system, as seen by threads outside of it.

use asmotion_port::Time;

/// A running system, for readers, writers and callers on their own threads. Any thread may call any method, and none of
/// them blocks.
pub(crate) trait RunHandle: Send + Sync {
    /// Current time of the system's clock.
    fn now(&self) -> Time;

    /// Returns the next order number among all samples of the run.
    fn next_order(&self) -> u64;

    /// Signals new data for the component at this position; an event-driven one cycles.
    fn trigger(&self, component: usize);

    /// Returns whether the run has not ended yet.
    fn is_running(&self) -> bool;
}
