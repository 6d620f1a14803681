//! State that threads outside share with a simulation: they write at any time, and the simulation reads it before its
//! next step.

use std::sync::atomic::{AtomicBool, AtomicI64, AtomicU64, Ordering};

use asmotion_port::Time;

use crate::growing_table::GrowingTable;
use crate::handle::RunHandle;

/// Shared with readers, writers and callers on other threads.
pub(super) struct SimulatedHandle {
    /// Current virtual time. Stored by the simulation, read by others.
    now: AtomicI64,
    /// Order number of the newest sample of the run.
    order: AtomicU64,
    /// Set after a flag in `triggered`, taken by the simulation before it reads them. With `Release` and `AcqRel`, a
    /// simulation that takes it sees that flag and the sample put in before. A flag set during the scan sets this
    /// again.
    any_triggered: AtomicBool,
    /// New data are waiting, by position of the component. Set by other threads, taken by the simulation.
    triggered: GrowingTable<AtomicBool>,
    /// Set when the simulation is dropped; read by other threads.
    ended: AtomicBool,
}

impl SimulatedHandle {
    pub(super) fn new(components: usize) -> Self {
        Self {
            now: AtomicI64::new(0),
            order: AtomicU64::new(0),
            any_triggered: AtomicBool::new(false),
            triggered: GrowingTable::with_room(components),
            ended: AtomicBool::new(false),
        }
    }

    /// Makes room for a component at this position.
    pub(super) fn extend_to(&self, component: usize) {
        self.triggered.extend_to(component);
    }

    pub(super) fn set_now(&self, now: Time) {
        self.now.store(now.nanos(), Ordering::Relaxed);
    }

    /// Returns the position of the last sample among all samples.
    pub(super) fn order(&self) -> u64 {
        self.order.load(Ordering::Relaxed)
    }

    pub(super) fn set_order(&self, order: u64) {
        self.order.store(order, Ordering::Relaxed);
    }

    pub(super) fn end(&self) {
        self.ended.store(true, Ordering::Release);
    }

    /// Passes the components to be triggered to `f`, and clears their flags.
    pub(super) fn take_triggered(&self, mut f: impl FnMut(usize)) {
        if !self.any_triggered.load(Ordering::Relaxed)
            || !self.any_triggered.swap(false, Ordering::AcqRel)
        {
            return;
        }
        for (component, triggered) in self.triggered.iter().enumerate() {
            if triggered.swap(false, Ordering::AcqRel) {
                f(component);
            }
        }
    }
}

impl RunHandle for SimulatedHandle {
    fn now(&self) -> Time {
        Time::from_nanos(self.now.load(Ordering::Relaxed))
    }

    fn next_order(&self) -> u64 {
        self.order.fetch_add(1, Ordering::Relaxed) + 1
    }

    fn trigger(&self, component: usize) {
        if let Some(triggered) = self.triggered.get(component) {
            triggered.store(true, Ordering::Release);
            self.any_triggered.store(true, Ordering::Release);
        }
    }

    fn is_running(&self) -> bool {
        !self.ended.load(Ordering::Acquire)
    }
}
