//! What all threads of a live system share: its clock, its wakers, its observers' queue.

mod events;
mod waker;

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::time::Instant;

use asmotion_port::Time;

pub(crate) use self::events::EventQueue;
pub(crate) use self::waker::ThreadWaker;
use crate::effects::Effects;
use crate::event::Event;
use crate::handle::RunHandle;

/// A live system, as its threads see it. Every thread has a clone; all of it is shared and may be used at any time.
#[derive(Clone)]
pub struct LiveContext {
    /// The clock's zero.
    zero: Instant,
    /// One for each component, by position in the system.
    wakers: Arc<[Arc<ThreadWaker>]>,
    events: Arc<EventQueue>,
    /// Position of the last sample among all samples of the run. `Relaxed`: only the counting matters.
    order: Arc<AtomicU64>,
    /// Set by the executor when the run ends; readers and writers outside look at it.
    ended: Arc<AtomicBool>,
    /// Set by a component's thread when its component wants all stopped; taken by the executor's thread.
    escalated: Arc<AtomicBool>,
}

impl LiveContext {
    pub(crate) fn new(
        zero: Instant,
        wakers: Arc<[Arc<ThreadWaker>]>,
        events: Arc<EventQueue>,
    ) -> Self {
        Self {
            zero,
            wakers,
            events,
            order: Arc::default(),
            ended: Arc::default(),
            escalated: Arc::default(),
        }
    }

    /// The waker of the component at this position.
    pub(crate) fn waker(&self, component: usize) -> Arc<ThreadWaker> {
        self.wakers
            .get(component)
            .map(Arc::clone)
            .unwrap_or_default()
    }

    /// The system runs no more.
    pub(crate) fn end(&self) {
        self.ended.store(true, Ordering::Release);
    }

    /// Whether all components are to stop; resets that.
    pub(crate) fn take_escalation(&self) -> bool {
        self.escalated.load(Ordering::Relaxed) && self.escalated.swap(false, Ordering::AcqRel)
    }

    fn trigger(&self, component: usize) {
        if let Some(waker) = self.wakers.get(component) {
            waker.trigger();
        }
    }

    /// The time since the clock's zero.
    pub fn now(&self) -> Time {
        Time::ZERO + self.zero.elapsed()
    }
}

impl Effects for LiveContext {
    fn emit(&mut self, at: Time, event: &Event<'_>) {
        self.events.push(at, event);
    }

    fn trigger(&mut self, component: usize) {
        LiveContext::trigger(self, component);
    }

    fn escalate(&mut self, _: usize) {
        self.escalated.store(true, Ordering::Release);
        self.events.wake();
    }

    /// The component's own thread looks at its deadlines before it sleeps.
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
