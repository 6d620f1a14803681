//! How many samples wait in a connection, as any thread can see.

use std::sync::{Arc, Weak};

use crossbeam_queue::ArrayQueue;

/// Tells how many samples wait in a queue, from any thread. It does not keep the queue alive, and slows neither of its ends.
///
/// While it looks, a reader does not notice yet that all writers are gone; it notices the next time.
#[derive(Clone)]
pub struct QueueGauge(Weak<dyn QueueLength>);

/// A queue whose length any thread can read.
pub(crate) trait QueueLength: Send + Sync {
    /// Number of samples that wait, which may have changed when this returns.
    fn length(&self) -> usize;
}

impl QueueGauge {
    pub(crate) fn new<Q: QueueLength + 'static>(queue: &Arc<Q>) -> Self {
        let queue: Arc<dyn QueueLength> = Arc::clone(queue) as Arc<dyn QueueLength>;
        Self(Arc::downgrade(&queue))
    }

    /// Number of samples that wait; 0 if the queue is gone.
    pub fn waiting(&self) -> usize {
        self.0.upgrade().map_or(0, |queue| queue.length())
    }

    /// Returns whether the queue is gone.
    pub fn is_gone(&self) -> bool {
        self.0.strong_count() == 0
    }

    /// Returns whether both look at the same queue.
    pub fn is_same(&self, other: &Self) -> bool {
        Weak::ptr_eq(&self.0, &other.0)
    }
}

impl<T: Send> QueueLength for ArrayQueue<T> {
    fn length(&self) -> usize {
        self.len()
    }
}
