//! The cause of a cycle: the trace of the message from outside that it consumed last. Publications and calls of the
//! cycle continue this trace.

use std::sync::OnceLock;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};

use asmotion_bus::TraceContext;
use crossbeam_queue::ArrayQueue;

/// The trace that a component's cycle continues. Its cycle never locks.
///
/// Threads that bring messages from a bus call [`record`](Self::record); everything else is done by the component's own
/// thread.
pub struct CycleCause {
    /// The newest trace that arrived over a bus since the last cycle. A queue of one, because a trace is wider than an
    /// atomic; made with the first trace, which most components never receive.
    newest: OnceLock<Box<ArrayQueue<TraceContext>>>,
    /// Set after a trace was put into `newest`, cleared before it is taken. Spares cycles without a trace the memory of the
    /// queue.
    has_arrived: AtomicBool,
    /// The current cycle's trace: both halves of the id, and the span; all zero without a trace. Written and read by
    /// the component's own thread alone, so `Relaxed` suffices; the atomics only make the type shareable.
    current: [AtomicU64; 3],
}

impl CycleCause {
    pub(crate) fn new() -> Self {
        Self {
            newest: OnceLock::new(),
            has_arrived: AtomicBool::new(false),
            current: Default::default(),
        }
    }

    /// Records the trace of an arriving message. The next cycle continues it unless a newer one arrives first.
    pub fn record(&self, trace: TraceContext) {
        let newest = self.newest.get_or_init(|| Box::new(ArrayQueue::new(1)));
        newest.force_push(trace);
        self.has_arrived.store(true, Ordering::Release);
    }

    /// Makes the newest recorded trace that of the cycle that begins.
    pub(crate) fn begin_cycle(&self) {
        let has_arrived = self.has_arrived.load(Ordering::Relaxed)
            && self.has_arrived.swap(false, Ordering::Acquire);
        self.set(has_arrived.then(|| self.take_newest()).flatten());
    }

    /// Makes the trace of a consumed message that of the current cycle; `None` changes nothing.
    pub(crate) fn continue_trace(&self, trace: Option<TraceContext>) {
        if trace.is_some() {
            self.set(trace);
        }
    }

    /// The trace that the current cycle continues.
    pub fn current(&self) -> Option<TraceContext> {
        let [high, low, span] = self
            .current
            .each_ref()
            .map(|part| part.load(Ordering::Relaxed));
        let id = (u128::from(high) << 64) | u128::from(low);
        (id != 0).then_some(TraceContext { id, span })
    }

    /// Returns the trace that has arrived for the next cycle and that of the last one.
    pub(crate) fn snapshot(&self) -> [Option<TraceContext>; 2] {
        let arrived = self.take_newest();
        if let (Some(trace), Some(newest)) = (arrived, self.newest.get()) {
            newest.force_push(trace);
        }
        [arrived, self.current()]
    }

    pub(crate) fn restore(&self, [arrived, present]: [Option<TraceContext>; 2]) {
        self.take_newest();
        self.has_arrived.store(false, Ordering::Relaxed);
        if let Some(trace) = arrived {
            self.record(trace);
        }
        self.set(present);
    }

    fn take_newest(&self) -> Option<TraceContext> {
        self.newest.get()?.pop()
    }

    fn set(&self, trace: Option<TraceContext>) {
        let (id, span) = trace.map_or((0, 0), |trace| (trace.id, trace.span));
        for (part, value) in self
            .current
            .iter()
            .zip([(id >> 64) as u64, id as u64, span])
        {
            part.store(value, Ordering::Relaxed);
        }
    }
}
