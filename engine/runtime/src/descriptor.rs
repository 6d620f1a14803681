//! The part of a component that other threads see while its own thread owns it.

use std::sync::atomic::{AtomicBool, AtomicU8, AtomicU64, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use asmotion_component::{
    AwaitedWriters, Declaration, Fault, Losses, PeerStatus, State, ThreadUse, Transition, Wire,
};
use asmotion_port::ChannelOpener;
use serde::{Deserialize, Serialize};

use crate::cause::CycleCause;
use crate::service::RequestQueue;

/// Duration of a component's cycles, on the clock it runs by.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
pub struct CycleTime {
    /// Sum over all cycles.
    pub total: Duration,
    /// The longest single cycle.
    pub longest: Duration,
}

impl CycleTime {
    /// Mean over this number of cycles; zero without cycles.
    pub fn mean(self, cycles: u64) -> Duration {
        let cycles = u32::try_from(cycles).unwrap_or(u32::MAX);
        self.total.checked_div(cycles).unwrap_or_default()
    }
}

/// The constant facts about a component, its wires, and its status. Held by the executor; the component's thread shares the
/// status.
pub(crate) struct ComponentDescriptor {
    pub name: Arc<str>,
    pub declaration: Arc<Declaration>,
    /// Position of the component in whose thread this one cycles: its own, unless it is a slave.
    pub thread: usize,
    /// Position of the component after which this one cycles; `None` unless it is a slave.
    pub master: Option<usize>,
    /// Opens channels into each input, by position.
    pub openers: Vec<Arc<dyn ChannelOpener>>,
    /// The request queue of each service, by position.
    pub queues: Vec<Arc<RequestQueue>>,
    /// The services of each reference, by position: their full names, and how they are called.
    pub wired: Vec<Vec<(String, Wire)>>,
    pub configure_on_startup: bool,
    pub run_on_startup: bool,
    pub may_interrupt: bool,
    /// The thread of a live system in which it cycles.
    pub thread_use: ThreadUse,
    /// The writers that stop before this component.
    pub awaited_writers: AwaitedWriters,
    pub status: Arc<ComponentStatus>,
    /// The cause of the component's cycles.
    pub cause: Arc<CycleCause>,
}

/// The changing facts about a component.
///
/// The component's thread writes all fields but `interrupt`, any thread reads them. The counters are independent of
/// each other, so they are `Relaxed`; `state` and `target` are stored with `Release` and read with `Acquire`, so that a
/// thread that sees a state sees the effects of the hooks before it.
pub(crate) struct ComponentStatus {
    state: AtomicU8,
    target: AtomicU8,
    pub cycles: AtomicU64,
    /// Current period in nanoseconds; zero without a period.
    period: AtomicU64,
    /// Number of missed periods.
    pub overruns: AtomicU64,
    /// Number of cycles that exceeded their deadline.
    pub late: AtomicU64,
    /// Duration of the cycles in nanoseconds: the sum, and the longest.
    spent: AtomicU64,
    longest: AtomicU64,
    /// Set by the executor when the component is to stop and allows interruption of its cycles; read by the cycle;
    /// cleared by the component's thread at the next start.
    pub interrupt: AtomicBool,
    /// What the component stands for cannot be reached.
    unreachable: AtomicBool,
    dropped: AtomicU64,
    misfits: AtomicU64,
    /// Number of samples that input ports refused for their values.
    refused: AtomicU64,
    /// Number of messages inside the component that wait for a later cycle, as of its last cycle.
    waiting: AtomicU64,
    /// The newest fault. The lock is held only while the fault is copied, and no successful cycle takes it.
    fault: Mutex<Option<Fault>>,
}

/// Status of a component in a frozen system.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct StatusSnapshot {
    target: State,
    cycles: u64,
    overruns: u64,
    late: u64,
    cycle_time: CycleTime,
    interrupt: bool,
    unreachable: bool,
    losses: Losses,
    refused: u64,
    fault: Option<Fault>,
}

impl ComponentDescriptor {
    /// Returns whether the position is vacant: its component has been removed.
    pub(crate) fn is_vacant(&self) -> bool {
        // no component has an empty name
        self.name.is_empty()
    }

    /// Number of messages lost on the way into each input, by position.
    pub(crate) fn lost(&self) -> impl Iterator<Item = u64> {
        self.openers.iter().map(|opener| opener.losses().total())
    }

    /// Number of requests refused because the queue of the service was full, by position.
    pub(crate) fn refused_requests(&self) -> impl Iterator<Item = u64> {
        self.queues.iter().map(|queue| queue.refused())
    }

    /// Number of messages that wait in the queues of each input, by position.
    pub(crate) fn waiting(&self) -> impl Iterator<Item = u64> {
        self.openers.iter().map(|opener| opener.waiting())
    }

    /// Number of requests that wait for each service, by position.
    pub(crate) fn waiting_requests(&self) -> impl Iterator<Item = u64> {
        self.queues.iter().map(|queue| queue.waiting())
    }

    /// The component's losses, including the messages lost on the way into its inputs, and refused requests.
    pub(crate) fn losses(&self) -> Losses {
        let Losses { dropped, misfits } = self.status.reported();
        let refused = self.status.refused.load(Ordering::Relaxed);
        Losses {
            dropped: dropped + self.lost().chain(self.refused_requests()).sum::<u64>(),
            misfits: misfits + refused,
        }
    }

    /// Sets the interrupt flag for a stop, if the component allows it.
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
            unreachable: AtomicBool::new(false),
            dropped: AtomicU64::new(0),
            misfits: AtomicU64::new(0),
            refused: AtomicU64::new(0),
            waiting: AtomicU64::new(0),
            fault: Mutex::new(None),
        }
    }

    pub(crate) fn state(&self) -> State {
        State::from_number(self.state.load(Ordering::Acquire))
    }

    /// The state that the transition under way leads to (RTT `getTargetState`); outside a transition, the current
    /// state.
    pub(crate) fn target(&self) -> State {
        State::from_number(self.target.load(Ordering::Acquire))
    }

    /// Records the state that the transition now begun leads to.
    pub(crate) fn set_target(&self, target: State) {
        self.target.store(target as u8, Ordering::Release);
    }

    pub(crate) fn set_state(&self, state: State) {
        self.set_target(state);
        self.state.store(state as u8, Ordering::Release);
    }

    /// Returns whether a cycle under way should return early.
    pub(crate) fn is_interrupted(&self) -> bool {
        self.interrupt.load(Ordering::Relaxed)
    }

    /// The part of the status that other components see.
    pub(crate) fn as_peer(&self) -> PeerStatus {
        PeerStatus {
            state: self.state(),
            is_reachable: !self.unreachable.load(Ordering::Relaxed),
        }
    }

    pub(crate) fn set_reachable(&self, is_reachable: bool) {
        self.unreachable.store(!is_reachable, Ordering::Relaxed);
    }

    /// Adds a cycle's duration to the statistics.
    pub(crate) fn record_cycle_time(&self, duration: Duration) {
        let nanos = u64::try_from(duration.as_nanos()).unwrap_or(u64::MAX);
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

    /// The losses that the component has reported.
    fn reported(&self) -> Losses {
        Losses {
            dropped: self.dropped.load(Ordering::Relaxed),
            misfits: self.misfits.load(Ordering::Relaxed),
        }
    }

    pub(crate) fn set_losses(&self, losses: Losses) {
        self.dropped.store(losses.dropped, Ordering::Relaxed);
        self.misfits.store(losses.misfits, Ordering::Relaxed);
    }

    /// Number of messages inside the component that wait for a later cycle.
    pub(crate) fn waiting(&self) -> u64 {
        self.waiting.load(Ordering::Relaxed)
    }

    pub(crate) fn set_waiting(&self, count: u64) {
        self.waiting.store(count, Ordering::Relaxed);
    }

    /// Counts samples that an input port refused for their values.
    pub(crate) fn add_refused(&self, count: u64) {
        self.refused.fetch_add(count, Ordering::Relaxed);
    }

    /// Returns the status without the state and the period, which are derived from the unit.
    pub(crate) fn snapshot(&self) -> StatusSnapshot {
        StatusSnapshot {
            target: self.target(),
            cycles: self.cycles.load(Ordering::Relaxed),
            overruns: self.overruns.load(Ordering::Relaxed),
            late: self.late.load(Ordering::Relaxed),
            cycle_time: self.cycle_time(),
            interrupt: self.is_interrupted(),
            unreachable: !self.as_peer().is_reachable,
            losses: self.reported(),
            refused: self.refused.load(Ordering::Relaxed),
            fault: self.fault().clone(),
        }
    }

    pub(crate) fn restore(&self, state: State, snapshot: &StatusSnapshot) {
        let nanos = |time: Duration| u64::try_from(time.as_nanos()).unwrap_or(u64::MAX);
        self.set_state(state);
        self.set_target(snapshot.target);
        self.cycles.store(snapshot.cycles, Ordering::Relaxed);
        self.overruns.store(snapshot.overruns, Ordering::Relaxed);
        self.late.store(snapshot.late, Ordering::Relaxed);
        let CycleTime { total, longest } = snapshot.cycle_time;
        self.spent.store(nanos(total), Ordering::Relaxed);
        self.longest.store(nanos(longest), Ordering::Relaxed);
        self.interrupt.store(snapshot.interrupt, Ordering::Relaxed);
        self.set_reachable(!snapshot.unreachable);
        self.set_losses(snapshot.losses);
        self.refused.store(snapshot.refused, Ordering::Relaxed);
        self.fault().clone_from(&snapshot.fault);
    }

    pub(crate) fn fault(&self) -> MutexGuard<'_, Option<Fault>> {
        self.fault.lock().unwrap_or_else(PoisonError::into_inner)
    }
}
