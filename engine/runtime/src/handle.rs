//! A running system, as threads outside of it see it.

use asmotion_port::Time;

/// A running system, for readers, writers and callers on threads of their own. Every method may be called by any thread,
/// and none blocks.
pub(crate) trait RunHandle: Send + Sync {
    /// The present time.
    fn now(&self) -> Time;

    /// The next position among all samples of the run.
    fn next_order(&self) -> u64;

    /// Something new is there for the component at this position; an event-driven one cycles.
    fn trigger(&self, component: usize);

    /// Whether the system still runs.
    fn is_running(&self) -> bool;
}
