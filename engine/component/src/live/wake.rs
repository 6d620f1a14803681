//! Waking a component's thread: one flag and one unpark; nobody waits.

use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Arc, OnceLock};
use std::thread::Thread;
use std::time::Instant;

use super::events::Events;
use crate::outside::Outside;
use crate::run::Beyond;
use crate::{Event, Time};

/// How others get at a component's thread.
#[derive(Default)]
pub(crate) struct Wake {
    /// Whether news make the component cycle.
    event_driven: AtomicBool,
    /// Something new is there.
    news: AtomicBool,
    /// Somebody asked for a cycle.
    called: AtomicBool,
    thread: OnceLock<Thread>,
}

impl Wake {
    pub(crate) fn set_thread(&self, thread: Thread) {
        // Set once, by the one who spawned it.
        let _ = self.thread.set(thread);
    }

    pub(crate) fn set_event_driven(&self, event_driven: bool) {
        self.event_driven.store(event_driven, Ordering::Relaxed);
    }

    /// Something new is there.
    pub(crate) fn news(&self) {
        if self.event_driven.load(Ordering::Relaxed) && !self.news.swap(true, Ordering::AcqRel) {
            self.unpark();
        }
    }

    /// A cycle is wanted, whatever drives the component.
    pub(crate) fn call(&self) {
        self.called.store(true, Ordering::Release);
        self.unpark();
    }

    pub(crate) fn unpark(&self) {
        if let Some(thread) = self.thread.get() {
            thread.unpark();
        }
    }

    pub(crate) fn take_news(&self) -> bool {
        self.news.swap(false, Ordering::AcqRel)
    }

    pub(crate) fn take_call(&self) -> bool {
        self.called.swap(false, Ordering::AcqRel)
    }
}

/// The world around a live component.
#[derive(Clone)]
pub(crate) struct World {
    /// The clock's zero.
    zero: Instant,
    /// Of each component, by its place in the system.
    wakes: Arc<[Arc<Wake>]>,
    events: Arc<Events>,
    order: Arc<AtomicU64>,
    ended: Arc<AtomicBool>,
    /// All are to stop.
    escalated: Arc<AtomicBool>,
}

impl World {
    pub(crate) fn new(zero: Instant, wakes: Arc<[Arc<Wake>]>, events: Arc<Events>) -> Self {
        Self {
            zero,
            wakes,
            events,
            order: Arc::default(),
            ended: Arc::default(),
            escalated: Arc::default(),
        }
    }

    /// How others get at the thread of the component at this place of the system.
    pub(crate) fn wake(&self, component: usize) -> Arc<Wake> {
        self.wakes
            .get(component)
            .map(Arc::clone)
            .unwrap_or_default()
    }

    /// The system runs no more.
    pub(crate) fn end(&self) {
        self.ended.store(true, Ordering::Release);
    }

    /// Whether all are to stop, as of now.
    pub(crate) fn take_escalation(&self) -> bool {
        self.escalated.load(Ordering::Relaxed) && self.escalated.swap(false, Ordering::AcqRel)
    }

    fn news(&self, component: usize) {
        if let Some(wake) = self.wakes.get(component) {
            wake.news();
        }
    }

    pub(crate) fn now(&self) -> Time {
        Time::ZERO + self.zero.elapsed()
    }
}

impl Outside for World {
    fn emit(&mut self, at: Time, event: &Event<'_>) {
        self.events.push(at, event);
    }

    fn trigger(&mut self, component: usize) {
        self.news(component);
    }

    fn escalate(&mut self, _: usize) {
        self.escalated.store(true, Ordering::Release);
        self.events.ring();
    }

    /// The component's own thread looks at its deadlines before it sleeps.
    fn wake_at(&mut self, _: usize, _: Time) {}

    fn next_order(&mut self) -> u64 {
        self.order.fetch_add(1, Ordering::Relaxed) + 1
    }
}

impl Beyond for World {
    fn now(&self) -> Time {
        World::now(self)
    }

    fn next_order(&self) -> u64 {
        self.order.fetch_add(1, Ordering::Relaxed) + 1
    }

    fn news(&self, component: usize) {
        World::news(self, component);
    }

    fn is_there(&self) -> bool {
        !self.ended.load(Ordering::Acquire)
    }
}
