//! The observers' queue: bounded. Events beyond its capacity are counted, and no thread waits for room.

use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::time::Duration;

use asmotion_port::{Notifier, Time};
use crossbeam_queue::ArrayQueue;

use crate::event::{Event, OwnedEvent};

/// Capacity of the queue, in events.
const WAITING: usize = 1 << 16;

/// Events on their way from the components' threads to the run's owner. Any thread pushes, the owner drains.
pub(crate) struct EventQueue {
    queue: ArrayQueue<(Time, OwnedEvent)>,
    /// Whether there is an observer; without one, events are not even built. Set by the run's owner, never cleared.
    observed: AtomicBool,
    /// Number of events dropped since the last drain.
    lost: AtomicU64,
    notifier: Notifier,
}

impl EventQueue {
    pub(crate) fn new(observed: bool) -> Self {
        Self {
            queue: ArrayQueue::new(WAITING),
            observed: AtomicBool::new(observed),
            lost: AtomicU64::new(0),
            notifier: Notifier::new(),
        }
    }

    /// Starts keeping events.
    pub(crate) fn observe(&self) {
        self.observed.store(true, Ordering::Relaxed);
    }

    /// Returns whether events are kept.
    pub(crate) fn is_observed(&self) -> bool {
        self.observed.load(Ordering::Relaxed)
    }

    pub(crate) fn push(&self, at: Time, event: &Event<'_>) {
        if !self.is_observed() {
            return;
        }
        if self.queue.push((at, OwnedEvent::of(event))).is_err() {
            self.lost.fetch_add(1, Ordering::Relaxed);
        }
        self.notifier.notify();
    }

    /// Passes the waiting events to `f`, then an [`Event::Lost`] if any were dropped.
    pub(crate) fn drain(&self, mut f: impl FnMut(Time, &Event<'_>)) {
        let mut last = Time::ZERO;
        for _ in 0..self.queue.len() {
            let Some((at, event)) = self.queue.pop() else {
                break;
            };
            last = at;
            f(at, &event.borrow());
        }
        let count = self.lost.swap(0, Ordering::Relaxed);
        if count > 0 {
            f(last, &Event::Lost { count });
        }
    }

    /// Ends the sleep of a thread in `wait`.
    pub(crate) fn wake(&self) {
        self.notifier.notify();
    }

    /// Sleeps until an event arrives, at most this long.
    pub(crate) fn wait(&self, timeout: Duration) {
        self.notifier.wait(timeout);
    }
}
