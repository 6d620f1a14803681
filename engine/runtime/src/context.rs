//! State shared by all threads of a live system: the clock, the wakers, and the observers' queue.

mod bell;
mod events;
mod waker;

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::time::Instant;

use asmotion_port::Time;

pub(crate) use self::bell::ExecutorBell;
pub(crate) use self::events::EventQueue;
pub(crate) use self::waker::{ThreadWaker, WakeTarget};
use crate::effects::Effects;
use crate::event::Event;
use crate::growing_table::GrowingTable;
use crate::handle::RunHandle;

/// A live system as its threads see it. Every thread has a clone; all of it is shared and may be used at any time.
#[derive(Clone)]
pub struct LiveContext {
    /// The clock's zero.
    zero: Instant,
    /// The waker of each component, by position in the system.
    wakers: Arc<GrowingTable<Arc<ThreadWaker>>>,
    events: Arc<EventQueue>,
    /// Order number of the newest sample of the run. `Relaxed`: only the counting matters.
    order: Arc<AtomicU64>,
    /// Set by the executor when the run ends; read by port readers and writers outside the system.
    ended: Arc<AtomicBool>,
    /// Set by the thread of a failed component whose activity stops all components; cleared by the executor's thread.
    escalated: Arc<AtomicBool>,
}

impl LiveContext {
    /// Creates the context of a system with this many components.
    pub(crate) fn new(zero: Instant, components: usize, events: Arc<EventQueue>) -> Self {
        Self {
            zero,
            wakers: Arc::new(GrowingTable::with_room(components)),
            events,
            order: Arc::default(),
            ended: Arc::default(),
            escalated: Arc::default(),
        }
    }

    /// The waker of the component at this position; one that wakes nothing if there is no such component.
    pub(crate) fn waker(&self, component: usize) -> Arc<ThreadWaker> {
        self.wakers
            .get(component)
            .map(Arc::clone)
            .unwrap_or_default()
    }

    /// Makes room for a component at this position.
    pub(crate) fn extend_to(&self, component: usize) {
        self.wakers.extend_to(component);
    }

    /// Marks the run as ended. `Release` pairs with the `Acquire` of `is_running`.
    pub(crate) fn end(&self) {
        self.ended.store(true, Ordering::Release);
    }

    /// Returns whether all components are to stop, and clears the request.
    pub(crate) fn take_escalation(&self) -> bool {
        self.escalated.load(Ordering::Relaxed) && self.escalated.swap(false, Ordering::AcqRel)
    }

    fn trigger(&self, component: usize) {
        if let Some(waker) = self.wakers.get(component) {
            waker.trigger();
        }
    }

    /// Time since the clock's zero, monotonic.
    pub fn now(&self) -> Time {
        Time::ZERO + self.zero.elapsed()
    }
}

impl Effects for LiveContext {
    fn emit(&mut self, at: Time, event: &Event<'_>) {
        self.events.push(at, event);
    }

    fn wants_report(&self, kind: &str) -> bool {
        self.events.wants_report(kind)
    }

    fn trigger(&mut self, component: usize) {
        LiveContext::trigger(self, component);
    }

    fn escalate(&mut self, _: usize) {
        self.escalated.store(true, Ordering::Release);
        self.events.wake();
    }

    /// Does nothing: the component's own thread checks its deadlines before it sleeps.
    fn wake_at(&mut self, _: usize, _: Time) {}

    fn next_order(&mut self) -> u64 {
        self.order.fetch_add(1, Ordering::Relaxed) + 1
    }
}

impl RunHandle for LiveContext {
    fn now(&self) -> Time {
        LiveContext::now(self)
    }

    fn next_order(&self) -> u64 {
        self.order.fetch_add(1, Ordering::Relaxed) + 1
    }

    fn trigger(&self, component: usize) {
        LiveContext::trigger(self, component);
    }

    fn is_running(&self) -> bool {
        !self.ended.load(Ordering::Acquire)
    }
}
