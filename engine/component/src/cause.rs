//! The cause of a cycle: the trace of what it consumed last from outside, which its publications and calls carry on.

use std::sync::atomic::{AtomicU64, Ordering};

use asmotion_bus::Trace;
use crossbeam_queue::ArrayQueue;

/// What a component's cycle follows from. Never locks.
pub(crate) struct Cause {
    /// Of what came over the bus since the last cycle, the newest.
    came: ArrayQueue<Trace>,
    /// Of the present cycle: both halves of the id, and the span; zeros for none. The component's own thread alone
    /// writes and reads them.
    present: [AtomicU64; 3],
}

impl Cause {
    pub(crate) fn new() -> Self {
        Self {
            came: ArrayQueue::new(1),
            present: Default::default(),
        }
    }

    /// Something of a trace comes in, for the next cycle.
    pub(crate) fn arrive(&self, trace: Trace) {
        self.came.force_push(trace);
    }

    /// A cycle begins.
    pub(crate) fn freeze(&self) {
        self.set(self.came.pop());
    }

    /// The present cycle has taken something of this trace.
    pub(crate) fn take(&self, trace: Option<Trace>) {
        if trace.is_some() {
            self.set(trace);
        }
    }

    /// What the present cycle follows from.
    pub(crate) fn present(&self) -> Option<Trace> {
        let [high, low, span] = (self.present.each_ref()).map(|part| part.load(Ordering::Relaxed));
        let id = (u128::from(high) << 64) | u128::from(low);
        (id != 0).then_some(Trace { id, span })
    }

    #[allow(clippy::cast_possible_truncation, reason = "the halves of an id")]
    fn set(&self, trace: Option<Trace>) {
        let (id, span) = trace.map_or((0, 0), |trace| (trace.id, trace.span));
        for (part, value) in (self.present.iter()).zip([(id >> 64) as u64, id as u64, span]) {
            part.store(value, Ordering::Relaxed);
        }
    }
}
