//! What everybody may know of a component while its thread has it.

use std::sync::atomic::{AtomicBool, AtomicU8, AtomicU64, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use crate::declaration::Declaration;
use crate::port::Inlet;
use crate::service::Inbox;
use crate::{CycleTime, Fault, Losses, State, Transition};

/// What does not change while the component runs, and its status.
pub(crate) struct Face {
    pub name: Arc<str>,
    pub declaration: Declaration,
    /// The component in whose thread it cycles; itself, unless it is a slave.
    pub thread: usize,
    /// The type of each input.
    pub inlets: Vec<Arc<dyn Inlet>>,
    /// The way into each service.
    pub inboxes: Vec<Arc<Inbox>>,
    pub configure_on_startup: bool,
    pub run_on_startup: bool,
    pub may_interrupt: bool,
    pub status: Arc<Status>,
}

/// What changes.
pub(crate) struct Status {
    state: AtomicU8,
    target: AtomicU8,
    pub cycles: AtomicU64,
    /// The present period in nanoseconds; none for what has none.
    period: AtomicU64,
    /// Periods missed.
    pub overruns: AtomicU64,
    /// Cycles that took longer than their deadline.
    pub late: AtomicU64,
    /// How long the cycles took, in nanoseconds: all of them, and the longest.
    spent: AtomicU64,
    longest: AtomicU64,
    /// Somebody wants the present cycle to end.
    pub interrupt: AtomicBool,
    dropped: AtomicU64,
    misfits: AtomicU64,
    /// The last fault. Held for as long as it is copied, and a fault is no part of a cycle that succeeds.
    fault: Mutex<Option<Fault>>,
}

impl Face {
    /// Lets a long cycle know that the component shall stop.
    pub(crate) fn allow_interrupt(&self, transition: Transition) {
        if transition == Transition::Stop && self.may_interrupt {
            self.status.interrupt.store(true, Ordering::Relaxed);
        }
    }
}

impl Status {
    pub(crate) fn new(state: State) -> Self {
        Self {
            state: AtomicU8::new(state as u8),
            target: AtomicU8::new(state as u8),
            cycles: AtomicU64::new(0),
            period: AtomicU64::new(0),
            overruns: AtomicU64::new(0),
            late: AtomicU64::new(0),
            spent: AtomicU64::new(0),
            longest: AtomicU64::new(0),
            interrupt: AtomicBool::new(false),
            dropped: AtomicU64::new(0),
            misfits: AtomicU64::new(0),
            fault: Mutex::new(None),
        }
    }

    pub(crate) fn state(&self) -> State {
        State::from_number(self.state.load(Ordering::Acquire))
    }

    /// The state a transition under way leads to (RTT `getTargetState`); without one, the state.
    pub(crate) fn target(&self) -> State {
        State::from_number(self.target.load(Ordering::Acquire))
    }

    /// A transition to a state begins.
    pub(crate) fn aim(&self, target: State) {
        self.target.store(target as u8, Ordering::Release);
    }

    pub(crate) fn enter(&self, state: State) {
        self.aim(state);
        self.state.store(state as u8, Ordering::Release);
    }

    /// Counts a cycle that took so long.
    pub(crate) fn spend(&self, took: Duration) {
        let nanos = u64::try_from(took.as_nanos()).unwrap_or(u64::MAX);
        self.spent.fetch_add(nanos, Ordering::Relaxed);
        self.longest.fetch_max(nanos, Ordering::Relaxed);
    }

    pub(crate) fn cycle_time(&self) -> CycleTime {
        CycleTime {
            total: Duration::from_nanos(self.spent.load(Ordering::Relaxed)),
            longest: Duration::from_nanos(self.longest.load(Ordering::Relaxed)),
        }
    }

    pub(crate) fn period(&self) -> Duration {
        Duration::from_nanos(self.period.load(Ordering::Relaxed))
    }

    pub(crate) fn set_period(&self, period: Duration) {
        let nanos = u64::try_from(period.as_nanos()).unwrap_or(u64::MAX);
        self.period.store(nanos, Ordering::Relaxed);
    }

    pub(crate) fn losses(&self) -> Losses {
        Losses {
            dropped: self.dropped.load(Ordering::Relaxed),
            misfits: self.misfits.load(Ordering::Relaxed),
        }
    }

    pub(crate) fn set_losses(&self, losses: Losses) {
        self.dropped.store(losses.dropped, Ordering::Relaxed);
        self.misfits.store(losses.misfits, Ordering::Relaxed);
    }

    pub(crate) fn fault(&self) -> MutexGuard<'_, Option<Fault>> {
        self.fault.lock().unwrap_or_else(PoisonError::into_inner)
    }
}
