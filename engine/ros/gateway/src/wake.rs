//! How other threads wake a bridge.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// Calls a bridge, from any thread.
pub type Wake = Arc<dyn Fn() + Send + Sync>;

/// How the threads of a node request a cycle of the bridge.
#[derive(Clone)]
pub struct CycleWakes {
    /// Wakes the bridge's thread.
    pub wake: Wake,
    /// Lends the calling thread to the cycle and those that it triggers: for the thread that reads messages, which has nothing else to
    /// do until more arrive. Called without locks; the thread must be able to drop the node.
    pub lend_thread: Wake,
}

/// Messages that have been put into queues by a thread that is lent to the bridge afterwards.
#[derive(Clone, Default)]
pub(crate) struct ArrivalFlag(Arc<AtomicBool>);

impl ArrivalFlag {
    /// Notes a message.
    pub(crate) fn note(&self) {
        self.0.store(true, Ordering::Release);
    }

    /// A function that lends the current thread to the bridge if messages have arrived since its last call.
    pub(crate) fn lender(&self, lend_thread: Wake) -> Wake {
        let arrived = Arc::clone(&self.0);
        Arc::new(move || {
            if arrived.swap(false, Ordering::AcqRel) {
                lend_thread();
            }
        })
    }
}
