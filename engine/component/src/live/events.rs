//! The observers' queue: bounded; what it cannot hold is counted, never waited for.

use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::time::Duration;

use asmotion_bus::Bell;
use crossbeam_queue::ArrayQueue;

use crate::event::Owned;
use crate::{Event, Time};

/// How many events may wait to be observed.
const WAITING: usize = 1 << 16;

/// Events on their way from the components' threads to the run's owner.
pub(crate) struct Events {
    queue: ArrayQueue<(Time, Owned)>,
    /// Whether anybody observes; otherwise events are not even built.
    observed: AtomicBool,
    lost: AtomicU64,
    bell: Bell,
}

impl Events {
    pub(crate) fn new(observed: bool) -> Self {
        Self {
            queue: ArrayQueue::new(WAITING),
            observed: AtomicBool::new(observed),
            lost: AtomicU64::new(0),
            bell: Bell::new(),
        }
    }

    /// From now on somebody observes.
    pub(crate) fn observe(&self) {
        self.observed.store(true, Ordering::Relaxed);
    }

    pub(crate) fn push(&self, at: Time, event: &Event<'_>) {
        if !self.observed.load(Ordering::Relaxed) {
            return;
        }
        if self.queue.push((at, Owned::of(event))).is_err() {
            self.lost.fetch_add(1, Ordering::Relaxed);
        }
        self.bell.ring();
    }

    /// Tells all that waits, and how many events were lost.
    pub(crate) fn drain(&self, mut tell: impl FnMut(Time, &Event<'_>)) {
        let mut last = Time::ZERO;
        for _ in 0..self.queue.len() {
            let Some((at, event)) = self.queue.pop() else {
                break;
            };
            last = at;
            tell(at, &event.lend());
        }
        let count = self.lost.swap(0, Ordering::Relaxed);
        if count > 0 {
            tell(last, &Event::Lost { count });
        }
    }

    /// Ends a sleep.
    pub(crate) fn ring(&self) {
        self.bell.ring();
    }

    /// Sleeps until an event comes, or so long.
    pub(crate) fn wait(&self, at_most: Duration) {
        self.bell.wait(at_most);
    }
}
