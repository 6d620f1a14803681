//! The cause of a cycle: the trace of the message from outside that it consumed last. Publications and calls of the
//! cycle continue this trace.

use std::sync::atomic::{AtomicU64, Ordering};

use asmotion_bus::TraceContext;
use crossbeam_queue::ArrayQueue;

/// The trace that a component's cycle continues. Never locks.
///
/// Threads that bring messages from a bus call [`arrive`](Self::arrive); everything else is done by the component's own
/// thread.
pub struct CycleCause {
    /// The newest trace that arrived over a bus since the last cycle. A queue of one, because a trace is wider than an
    /// atomic.
    arrived: ArrayQueue<TraceContext>,
    /// The current cycle's trace: both halves of the id, and the span; all zero without a trace. Written and read by
    /// the component's own thread alone, so `Relaxed` suffices; the atomics only make the type shareable.
    present: [AtomicU64; 3],
}

impl CycleCause {
    pub(crate) fn new() -> Self {
        Self {
            arrived: ArrayQueue::new(1),
            present: Default::default(),
        }
    }

    /// Records the trace of an arriving message. The next cycle continues it unless a newer one arrives first.
    pub fn arrive(&self, trace: TraceContext) {
        self.arrived.force_push(trace);
    }

    /// Makes the newest recorded trace that of the cycle that begins.
    pub(crate) fn freeze(&self) {
        self.set(self.arrived.pop());
    }

    /// Makes the trace of a consumed message that of the current cycle; `None` changes nothing.
    pub(crate) fn take(&self, trace: Option<TraceContext>) {
        if trace.is_some() {
            self.set(trace);
        }
    }

    /// The trace that the current cycle continues.
    pub fn present(&self) -> Option<TraceContext> {
        let [high, low, span] = self
            .present
            .each_ref()
            .map(|part| part.load(Ordering::Relaxed));
        let id = (u128::from(high) << 64) | u128::from(low);
        (id != 0).then_some(TraceContext { id, span })
    }

    /// Returns the trace that has arrived for the next cycle and that of the last one.
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

    fn set(&self, trace: Option<TraceContext>) {
        let (id, span) = trace.map_or((0, 0), |trace| (trace.id, trace.span));
        for (part, value) in self
            .present
            .iter()
            .zip([(id >> 64) as u64, id as u64, span])
        {
            part.store(value, Ordering::Relaxed);
        }
    }
}
