//! Wakes a component's thread: a flag and an unpark, neither of which blocks.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, OnceLock, Weak};
use std::thread::Thread;

use super::bell::ExecutorBell;

/// What runs the cycles of a component.
pub(crate) enum WakeTarget {
    /// A thread of its own.
    Thread(Thread),
    /// The executor threads, in which it has this seat.
    Seat {
        bell: Arc<ExecutorBell>,
        seat: usize,
        /// Weak: a component may own the thread that it is lent.
        turns: Weak<dyn LentTurns>,
    },
}

/// Runs turns of the executor threads in a thread that is lent to them.
pub(crate) trait LentTurns: Send + Sync {
    /// Runs the turns that are ready, as long as they are expected to be brief, in the current thread.
    fn run_lent(self: Arc<Self>);
}

/// Lets other threads wake a component's thread.
///
/// A flag is set before the unpark, and the component's thread takes the flags before it parks. If a flag is set after
/// the thread has checked it, the unpark follows the check as well, so the next park returns at once and the thread
/// checks again. No wake-up is lost, and no lock is needed. The [bell](ExecutorBell) of executor threads does the same for
/// their seats.
#[derive(Default)]
pub(crate) struct ThreadWaker {
    /// Whether new data trigger a cycle. Stored by the component's thread when its drive or its state changes, read by the
    /// threads that bring data. `Relaxed`: the component's thread stores it before it takes `triggered`, and other threads
    /// set `triggered` before they read it; the swap that comes second in the order of `triggered` sees what preceded the
    /// first one.
    event_driven: AtomicBool,
    /// New data are waiting. Set by any thread, taken by the component's. The swap lets only the first of several
    /// triggers unpark, and publishes (`AcqRel`) the data put into queues before it. Set whatever drives the component, so
    /// that a request that arrives while the component stops is not overlooked.
    triggered: AtomicBool,
    /// A cycle was requested explicitly. Set by the run's owner, taken by the component's thread.
    cycle_requested: AtomicBool,
    /// What to wake. Set once by the run's owner, before any component of the thread has a cycle; nothing needs to wake it
    /// earlier.
    target: OnceLock<WakeTarget>,
}

impl WakeTarget {
    pub(crate) fn wake(&self) {
        match self {
            Self::Thread(thread) => thread.unpark(),
            Self::Seat { bell, seat, .. } => bell.wake(*seat),
        }
    }
}

impl ThreadWaker {
    pub(crate) fn set_target(&self, target: WakeTarget) {
        // never set twice: only the run's owner calls this
        let _ = self.target.set(target);
    }

    pub(crate) fn set_event_driven(&self, event_driven: bool) {
        self.event_driven.store(event_driven, Ordering::Relaxed);
    }

    /// Signals new data: an event-driven component cycles.
    pub(crate) fn trigger(&self) {
        if !self.triggered.swap(true, Ordering::AcqRel) && self.event_driven.load(Ordering::Relaxed)
        {
            self.wake();
        }
    }

    /// Requests a cycle, whatever drives the component.
    pub(crate) fn request_cycle(&self) {
        self.cycle_requested.store(true, Ordering::Release);
        self.wake();
    }

    /// Requests a cycle, and lends the current thread to the executor threads for it and what it triggers: nothing has to be
    /// woken then. A component with a thread of its own is woken.
    pub(crate) fn lend_thread(&self) {
        self.cycle_requested.store(true, Ordering::Release);
        let Some(WakeTarget::Seat { bell, seat, turns }) = self.target.get() else {
            return self.wake();
        };
        // none are left when the run has ended
        if let Some(turns) = turns.upgrade() {
            bell.note(*seat);
            turns.run_lent();
        }
    }

    fn wake(&self) {
        if let Some(target) = self.target.get() {
            target.wake();
        }
    }

    pub(crate) fn take_trigger(&self) -> bool {
        self.triggered.swap(false, Ordering::AcqRel)
    }

    pub(crate) fn take_cycle_request(&self) -> bool {
        self.cycle_requested.swap(false, Ordering::AcqRel)
    }
}
