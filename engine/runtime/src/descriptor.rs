//! What other threads see of a component while its own thread has it.

use std::sync::atomic::{AtomicBool, AtomicU8, AtomicU64, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use asmotion_component::{Declaration, Fault, Losses, State, Transition};
use asmotion_port::ChannelOpener;
use serde::{Deserialize, Serialize};

use crate::service::RequestQueue;

/// How long the cycles of a component took, on the clock that it runs by.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
pub struct CycleTime {
    /// All of them.
    pub total: Duration,
    /// The longest.
    pub longest: Duration,
}

impl CycleTime {
    /// The mean of this number of cycles.
    pub fn mean(self, cycles: u64) -> Duration {
        let cycles = u32::try_from(cycles).unwrap_or(u32::MAX);
        self.total.checked_div(cycles).unwrap_or_default()
    }
}

/// What does not change while the component runs, and its status. The executor has it; the component's thread shares the
/// status.
pub(crate) struct ComponentDescriptor {
    pub name: Arc<str>,
    pub declaration: Declaration,
    /// Position of the component in whose thread it cycles; its own, unless it is a slave.
    pub thread: usize,
    /// Opens channels into each input.
    pub openers: Vec<Arc<dyn ChannelOpener>>,
    /// The requests of each service.
    pub queues: Vec<Arc<RequestQueue>>,
    pub configure_on_startup: bool,
    pub run_on_startup: bool,
    pub may_interrupt: bool,
    pub status: Arc<ComponentStatus>,
}

/// What changes while the component runs.
///
/// The component's thread writes all fields but `interrupt`, any thread reads them. The counters are independent of each
/// other, so they are `Relaxed`; `state` and `target` are stored with `Release` and read with `Acquire`, so that a thread
/// that sees a state sees what the hooks before it did.
pub(crate) struct ComponentStatus {
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
    /// Set by the executor when the component is to stop and lets its cycles be interrupted; read by the cycle; cleared by
    /// the component's thread at the next start.
    pub interrupt: AtomicBool,
    dropped: AtomicU64,
    misfits: AtomicU64,
    /// The last fault. Held for as long as it is copied, and a fault is no part of a cycle that succeeds.
    fault: Mutex<Option<Fault>>,
}

/// A component's status in a frozen system.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct StatusSnapshot {
    target: State,
    cycles: u64,
    overruns: u64,
    late: u64,
    cycle_time: CycleTime,
    interrupt: bool,
    losses: Losses,
    fault: Option<Fault>,
}

impl ComponentDescriptor {
    /// Tells a long cycle that the component is to stop.
    pub(crate) fn allow_interrupt(&self, transition: Transition) {
        if transition == Transition::Stop && self.may_interrupt {
            self.status.interrupt.store(true, Ordering::Relaxed);
        }
    }
}

impl ComponentStatus {
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

    /// Whether a cycle under way is to return.
    pub(crate) fn is_interrupted(&self) -> bool {
        self.interrupt.load(Ordering::Relaxed)
    }

    /// Counts a cycle and its duration.
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

    /// Everything but the state and the period, which follow from the unit.
    pub(crate) fn snapshot(&self) -> StatusSnapshot {
        StatusSnapshot {
            target: self.target(),
            cycles: self.cycles.load(Ordering::Relaxed),
            overruns: self.overruns.load(Ordering::Relaxed),
            late: self.late.load(Ordering::Relaxed),
            cycle_time: self.cycle_time(),
            interrupt: self.is_interrupted(),
            losses: self.losses(),
            fault: self.fault().clone(),
        }
    }

    pub(crate) fn restore(&self, state: State, snapshot: &StatusSnapshot) {
        let nanos = |time: Duration| u64::try_from(time.as_nanos()).unwrap_or(u64::MAX);
        self.enter(state);
        self.aim(snapshot.target);
        self.cycles.store(snapshot.cycles, Ordering::Relaxed);
        self.overruns.store(snapshot.overruns, Ordering::Relaxed);
        self.late.store(snapshot.late, Ordering::Relaxed);
        let CycleTime { total, longest } = snapshot.cycle_time;
        self.spent.store(nanos(total), Ordering::Relaxed);
        self.longest.store(nanos(longest), Ordering::Relaxed);
        self.interrupt.store(snapshot.interrupt, Ordering::Relaxed);
        self.set_losses(snapshot.losses);
        self.fault().clone_from(&snapshot.fault);
    }

    pub(crate) fn fault(&self) -> MutexGuard<'_, Option<Fault>> {
        self.fault.lock().unwrap_or_else(PoisonError::into_inner)
    }
}
