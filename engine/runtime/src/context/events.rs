//! The observers' queue: bounded. Events beyond its capacity are counted, and no thread waits for room.

use std::sync::OnceLock;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Duration;

use asmotion_port::{Notifier, Time};
use crossbeam_queue::ArrayQueue;

use crate::event::{Event, OwnedEvent, ReportInterest};
use crate::growing_table::GrowingTable;

/// Capacity of the queue, in events.
const WAITING: usize = 1 << 16;

/// Events on their way from the components' threads to the run's owner. Any thread pushes, the owner drains.
pub(crate) struct EventQueue {
    queue: ArrayQueue<(Time, OwnedEvent)>,
    /// The reports that observers use, each kind of interest once; empty without an observer, in which case events are not even
    /// built. Entries are added by the run's owner, in order, and never removed.
    interests: GrowingTable<OnceLock<ReportInterest>>,
    /// Number of events dropped since the last drain.
    lost: AtomicU64,
    notifier: Notifier,
}

impl EventQueue {
    pub(crate) fn new() -> Self {
        Self {
            queue: ArrayQueue::new(WAITING),
            interests: GrowingTable::with_room(0),
            lost: AtomicU64::new(0),
            notifier: Notifier::new(),
        }
    }

    /// Starts keeping events, for an observer with this interest. Called by the run's owner.
    pub(crate) fn observe(&self, reports: ReportInterest) {
        if self.interests().any(|known| known == reports) {
            return;
        }
        let position = self.interests().count();
        self.interests.extend_to(position);
        if let Some(entry) = self.interests.get(position) {
            // the owner is the only one that adds entries, so this one is empty
            let _ = entry.set(reports);
        }
    }

    fn interests(&self) -> impl Iterator<Item = ReportInterest> {
        self.interests.iter().map_while(OnceLock::get).copied()
    }

    /// Returns whether events are kept.
    fn is_observed(&self) -> bool {
        self.interests().next().is_some()
    }

    /// Returns whether any observer uses reports of this kind.
    pub(crate) fn wants_report(&self, kind: &str) -> bool {
        self.interests().any(|reports| reports.includes(kind))
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
