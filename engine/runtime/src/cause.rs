//! The cause of a cycle: the trace of what it consumed last from outside, which its publications and calls carry on.

use std::sync::atomic::{AtomicU64, Ordering};

use asmotion_bus::TraceContext;
use crossbeam_queue::ArrayQueue;

/// What a component's cycle follows from. Never locks.
///
/// Threads that bring messages from a bus call [`arrive`](Self::arrive); everything else is done by the component's own
/// thread.
pub struct CycleCause {
    /// The newest trace that came over a bus since the last cycle. A queue of one, since a trace is wider than an atomic.
    arrived: ArrayQueue<TraceContext>,
    /// The present cycle's trace: both halves of the id, and the span; zeros for none. Written and read by the component's
    /// own thread alone, so `Relaxed` is enough; atomics only make it shareable.
    present: [AtomicU64; 3],
}

impl CycleCause {
    pub(crate) fn new() -> Self {
        Self {
            arrived: ArrayQueue::new(1),
            present: Default::default(),
        }
    }

    /// A message of a trace comes in; the next cycle follows from it, unless a newer one comes before.
    pub fn arrive(&self, trace: TraceContext) {
        self.arrived.force_push(trace);
    }

    /// A cycle begins.
    pub(crate) fn freeze(&self) {
        self.set(self.arrived.pop());
    }

    /// The present cycle has taken something of this trace.
    pub(crate) fn take(&self, trace: Option<TraceContext>) {
        if trace.is_some() {
            self.set(trace);
        }
    }

    /// What the present cycle follows from.
    pub fn present(&self) -> Option<TraceContext> {
        let [high, low, span] = (self.present.each_ref()).map(|part| part.load(Ordering::Relaxed));
        let id = (u128::from(high) << 64) | u128::from(low);
        (id != 0).then_some(TraceContext { id, span })
    }

    /// The trace that has arrived for the next cycle, and that of the present one.
    pub(crate) fn snapshot(&self) -> [Option<TraceContext>; 2] {
        let arrived = self.arrived.pop();
        if let Some(trace) = arrived {
            self.arrived.force_push(trace);
        }
        [arrived, self.present()]
    }

    pub(crate) fn restore(&self, [arrived, present]: [Option<TraceContext>; 2]) {
        self.arrived.pop();
        if let Some(trace) = arrived {
            self.arrived.force_push(trace);
        }
        self.set(present);
    }

    #[allow(clippy::cast_possible_truncation, reason = "the halves of an id")]
    fn set(&self, trace: Option<TraceContext>) {
        let (id, span) = trace.map_or((0, 0), |trace| (trace.id, trace.span));
        for (part, value) in (self.present.iter()).zip([(id >> 64) as u64, id as u64, span]) {
            part.store(value, Ordering::Relaxed);
        }
    }
}
