//! Counters of lost messages.

use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use asmotion_connection::prefetch;

/// Number of messages lost on the way into an input port. Shared by the port and the writing ends of its connections, which
/// may be in other threads; a count alone orders nothing, so all accesses are `Relaxed`.
#[derive(Debug, Clone, Default)]
pub struct LossCounter(Arc<AtomicU64>);

impl LossCounter {
    /// Counts messages that were lost.
    pub fn add(&self, count: u64) {
        self.0.fetch_add(count, Ordering::Relaxed);
    }

    /// Number of messages lost so far.
    pub fn total(&self) -> u64 {
        self.0.load(Ordering::Relaxed)
    }

    /// Prefetches the number.
    pub(crate) fn prefetch(&self) {
        prefetch(&*self.0);
    }

    /// Replaces the number of lost messages, when a frozen state is restored.
    pub fn set(&self, total: u64) {
        self.0.store(total, Ordering::Relaxed);
    }
}
