//! Subscriptions: bounded queues with an overflow policy and a count of dropped messages.

use std::fmt;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::{Duration, Instant};

use crossbeam_queue::ArrayQueue;

use crate::deadline::deadline_after;
use crate::envelope::Envelope;
use asmotion_connection::Notifier;

/// Queueing policy of a subscription.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum QueuePolicy {
    /// The newest message only, for states. Replaced messages are out of date and do not count as dropped (TCA
    /// `receiveLast`).
    Latest,
    /// All messages up to a limit, for sequences (TCA `receiveAll`).
    All {
        /// Capacity, in messages.
        size: usize,
        /// The message to drop when the queue is full. Drops are counted in either case.
        overflow: Overflow,
    },
}

/// The message to drop when a queue is full.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Overflow {
    /// Drops the oldest message.
    DropOldest,
    /// Drops the new message.
    DropNewest,
}

/// Counts of a subscription's messages that were not passed to the reader.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct SubscriptionCounts {
    /// Dropped because the queue was full.
    pub dropped: u64,
    /// Never arrived, inferred from gaps in the publishers' numbers.
    pub missed: u64,
    /// Arrived again and discarded.
    pub duplicates: u64,
    /// Arrived in a form that could not be decoded.
    pub unreadable: u64,
    /// Waited for an earlier run of the reader's process, and were discarded when the subscription began.
    pub discarded: u64,
}

#[derive(Default)]
struct AtomicSubscriptionCounts {
    dropped: AtomicU64,
    missed: AtomicU64,
    duplicates: AtomicU64,
    unreadable: AtomicU64,
    discarded: AtomicU64,
}

/// The sending end of a subscription's queue, for back ends.
#[derive(Clone)]
pub struct SubscriptionSender {
    shared: Arc<SubscriptionQueue>,
}

struct SubscriptionQueue {
    queue: ArrayQueue<QueuedMessage>,
    policy: QueuePolicy,
    counts: AtomicSubscriptionCounts,
    notifier: Arc<Notifier>,
}

/// A message in a queue.
struct QueuedMessage {
    envelope: Envelope,
    queued_at: Instant,
}

impl SubscriptionSender {
    /// Creates a queue. The notifier is notified of every message.
    pub fn new(policy: QueuePolicy, notifier: Arc<Notifier>) -> Self {
        let size = match policy {
            QueuePolicy::Latest => 1,
            QueuePolicy::All { size, .. } => size.max(1),
        };
        Self {
            shared: Arc::new(SubscriptionQueue {
                queue: ArrayQueue::new(size),
                policy,
                counts: AtomicSubscriptionCounts::default(),
                notifier,
            }),
        }
    }

    /// Appends a message; never blocks.
    pub fn push(&self, envelope: Envelope) {
        let shared = &self.shared;
        let message = QueuedMessage {
            envelope,
            queued_at: Instant::now(),
        };
        let dropped = match shared.policy {
            QueuePolicy::Latest => {
                shared.queue.force_push(message);
                false
            }
            QueuePolicy::All {
                overflow: Overflow::DropOldest,
                ..
            } => shared.queue.force_push(message).is_some(),
            QueuePolicy::All {
                overflow: Overflow::DropNewest,
                ..
            } => shared.queue.push(message).is_err(),
        };
        if dropped {
            shared.counts.dropped.fetch_add(1, Ordering::Relaxed);
        }
        shared.notifier.notify();
    }

    /// Sets the total number of messages that never arrived.
    pub fn set_missed(&self, missed: u64) {
        self.shared.counts.missed.store(missed, Ordering::Relaxed);
    }

    /// Sets the number of messages that waited for an earlier run of the process and were discarded.
    pub fn set_discarded(&self, discarded: u64) {
        self.shared
            .counts
            .discarded
            .store(discarded, Ordering::Relaxed);
        self.shared.notifier.notify();
    }

    /// Counts a message that arrived again.
    pub fn count_duplicate(&self) {
        self.shared
            .counts
            .duplicates
            .fetch_add(1, Ordering::Relaxed);
    }

    /// Counts a message that could not be decoded.
    pub fn count_unreadable(&self) {
        self.shared
            .counts
            .unreadable
            .fetch_add(1, Ordering::Relaxed);
    }

    /// Creates the reading end, which calls `on_drop` on drop.
    pub fn subscription(&self, on_drop: impl FnOnce() + Send + 'static) -> Subscription {
        Subscription {
            shared: Arc::clone(&self.shared),
            on_drop: Some(Box::new(on_drop)),
        }
    }

    /// Returns whether both are senders of the same queue.
    pub fn is_same(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.shared, &other.shared)
    }
}

/// The reading end of a subscription. Dropping it unsubscribes.
pub struct Subscription {
    shared: Arc<SubscriptionQueue>,
    on_drop: Option<Box<dyn FnOnce() + Send>>,
}

impl Subscription {
    /// Removes and returns the next message, if there is one. Its age includes the time for which it waited in the queue: a
    /// reader that stood still does not take it for new.
    pub fn try_next(&self) -> Option<Envelope> {
        let QueuedMessage {
            mut envelope,
            queued_at,
        } = self.shared.queue.pop()?;
        envelope.age = envelope.age.saturating_add(queued_at.elapsed());
        Some(envelope)
    }

    /// Removes and returns the next message, waiting at most for `timeout`.
    pub fn next_within(&self, timeout: Duration) -> Option<Envelope> {
        let until = deadline_after(timeout);
        loop {
            if let Some(envelope) = self.try_next() {
                return Some(envelope);
            }
            let remaining = until.saturating_duration_since(Instant::now());
            if remaining.is_zero() {
                return None;
            }
            self.shared.notifier.wait(remaining);
        }
    }

    /// Returns how many messages were dropped because the queue was full.
    pub fn dropped(&self) -> u64 {
        self.shared.counts.dropped.load(Ordering::Relaxed)
    }

    /// Returns the counts of messages that were not passed on.
    pub fn counts(&self) -> SubscriptionCounts {
        let counts = &self.shared.counts;
        SubscriptionCounts {
            dropped: counts.dropped.load(Ordering::Relaxed),
            missed: counts.missed.load(Ordering::Relaxed),
            duplicates: counts.duplicates.load(Ordering::Relaxed),
            unreadable: counts.unreadable.load(Ordering::Relaxed),
            discarded: counts.discarded.load(Ordering::Relaxed),
        }
    }
}

impl Drop for Subscription {
    fn drop(&mut self) {
        if let Some(leave) = self.on_drop.take() {
            leave();
        }
    }
}

impl fmt::Debug for Subscription {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Subscription")
            .field("policy", &self.shared.policy)
            .field("waiting", &self.shared.queue.len())
            .field("dropped", &self.dropped())
            .finish()
    }
}
