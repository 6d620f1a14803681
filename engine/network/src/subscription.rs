//! Subscriptions of ports to topics of the bus.
//!
//! In a live system, the receiving thread puts a message into the port without waking another thread. In a simulation,
//! messages enter between two steps, so they wait for the adapter.

use std::sync::atomic::{AtomicBool, Ordering, fence};
use std::sync::{Arc, Mutex, MutexGuard, OnceLock, PoisonError, TryLockError};

use asmotion_bus::{
    BusError, Notifier, Overflow, Pattern, QueuePolicy, Subscription, SubscriptionCounts,
};
use asmotion_datum::{DatumError, DatumProblem, Schema};
use asmotion_port::{BufferKind, Time};
use asmotion_runtime::{CycleCause, Effects, InjectionPort, LiveContext, OuterInput};

use crate::identity::BusIdentity;

/// Minimum capacity of a topic's queue on the bus.
const WAITING: usize = 256;

/// A port's subscription to a topic. Each port has its own queue on the bus, so that ports do not wait for each other,
/// and operators can see which of them does not keep up.
#[derive(Clone)]
pub(crate) struct TopicSubscription(Arc<DeliveryGate>);

/// Lets one thread at a time move messages from the bus's queue into the port, without ever blocking a thread.
///
/// Threads of the bus call [`notify`](Self::notify) after they have put a message into the queue; in a simulation the
/// executor's thread calls [`drain`](Self::drain). Several threads may arrive at once. The one that acquires the lock
/// drains the queue; the others leave, and rely on it to see their messages. The protocol is:
///
/// 1. A thread sets `pending`, then tries the lock. If it fails, another thread holds the lock.
/// 2. The holder clears `pending` *after* it has acquired the lock and *before* it drains, and reads `pending` again
///    *after* it has released the lock.
///
/// A message is in the queue before its thread sets `pending`. If the holder clears the flag after that, its swap reads
/// what the thread's swap wrote, or a later swap of the same chain, so it sees the message when it drains. If it clears
/// the flag before that, it must see the flag when it reads it again. In this pattern, two threads each write one
/// location and read the other (here flag and lock), and release and acquire do not order the accesses; hence the two
/// `SeqCst` fences, one of which comes first. If it is the thread's, the holder's second read sees the flag. If it is
/// the holder's, the thread's attempt follows the release, so it fails because of another holder, to which the same
/// applies. So no message stays behind.
///
/// A blocking lock would be simpler, but a thread of the bus would then wait for a port that copies and converts.
struct DeliveryGate {
    /// Wakes the thread that calls the adapter.
    notifier: Arc<Notifier>,
    /// The context with which threads of the bus put messages into the port. Set once, before the bus thread starts, or when a subscription of a running system begins;
    /// until then, and throughout a simulation, they notify the adapter instead.
    context: OnceLock<LiveContext>,
    /// There may be messages that no thread is about to drain; see the type's documentation.
    pending: AtomicBool,
    /// Another connection into the same input is to take the messages over. Set and cleared by the owner of the system.
    has_successor: AtomicBool,
    /// Name of the reader outside, and the topic.
    name: (String, String),
    queue: QueuePolicy,
    /// `None` until the subscription has been made.
    route: Mutex<Option<TopicRoute>>,
}

/// Treatment of the time that messages have waited at their senders.
#[derive(Debug, Clone, Copy)]
enum Ages {
    /// It counts towards the age limits of the connections.
    Counted,
    /// The clock of a simulation and the time that messages take in the world outside have nothing in common.
    Ignored,
}

/// The route from a topic to a port.
struct TopicRoute {
    subscription: Subscription,
    /// `None` after a connection has been closed, until its successor takes over: messages wait.
    port: Option<InjectionPort>,
    /// Full name of the input.
    input: String,
    /// Schema of the port's type.
    schema: Schema,
    /// The cause of the next cycle of the port's component.
    cause: Arc<CycleCause>,
    /// Messages of this incarnation are skipped: they were sent by this process and delivered within it.
    own_incarnation: Option<u64>,
    /// Numbers of lost messages that have been reported.
    lost: SubscriptionCounts,
    /// Number of messages for an earlier run of this process that have been reported as discarded.
    discarded: u64,
}

impl TopicSubscription {
    /// Subscribes an input to a topic of the bus, without messages of the incarnation `own_incarnation`. `reader` is the name of
    /// its component outside.
    pub(crate) fn new(
        reader: &str,
        topic: &str,
        kind: BufferKind,
        input: OuterInput<'_>,
        own_incarnation: Option<u64>,
        identity: &BusIdentity,
    ) -> Result<Self, BusError> {
        let gate = Arc::new(DeliveryGate {
            notifier: Arc::clone(&identity.notifier),
            context: OnceLock::new(),
            pending: AtomicBool::new(false),
            has_successor: AtomicBool::new(false),
            name: (reader.to_owned(), topic.to_owned()),
            queue: queue_policy(kind),
            route: Mutex::default(),
        });
        // weak, because the gate owns the subscription, which owns the notifier
        let notified = Arc::downgrade(&gate);
        let notifier = Notifier::calling(move || {
            if let Some(gate) = notified.upgrade() {
                gate.notify();
            }
        });
        let pattern = Pattern::new(topic);
        let (policy, notifier) = (gate.queue, Arc::new(notifier));
        let route = TopicRoute {
            subscription: identity.bus.subscribe(reader, &pattern, policy, notifier)?,
            input: input.port.name().to_owned(),
            port: Some(input.port),
            schema: input.schema.clone(),
            cause: input.cause,
            own_incarnation,
            lost: SubscriptionCounts::default(),
            discarded: 0,
        };
        *gate.lock() = Some(route);
        Ok(Self(gate))
    }

    /// Returns whether another connection into this input can take the messages of the topic over.
    pub(crate) fn suits(
        &self,
        (reader, topic): (&str, &str),
        input: &str,
        kind: BufferKind,
    ) -> bool {
        let gate = &self.0;
        let has_input = |route: &TopicRoute| route.input == input;
        (&*gate.name.0, &*gate.name.1) == (reader, topic)
            && gate.queue == queue_policy(kind)
            && gate.lock().as_ref().is_some_and(has_input)
    }

    /// Announces a connection that takes the messages over once the present one is closed, or takes the announcement back.
    pub(crate) fn set_successor(&self, is_announced: bool) {
        self.0.has_successor.store(is_announced, Ordering::Relaxed);
    }

    /// Closes the present connection and lets messages wait for its successor. Returns whether there is one.
    pub(crate) fn pause(&self) -> bool {
        let has_successor = self.0.has_successor.swap(false, Ordering::Relaxed);
        if has_successor && let Some(route) = &mut *self.0.lock() {
            route.port = None;
        }
        has_successor
    }

    /// Has the messages moved through this connection from now on, those that have waited first.
    pub(crate) fn continue_through(&self, port: InjectionPort) {
        if let Some(route) = &mut *self.0.lock() {
            route.port = Some(port);
        }
        self.notify();
    }

    /// Returns whether both are the same subscription.
    pub(crate) fn is_same(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.0, &other.0)
    }

    /// Has the messages that have arrived moved into the port.
    pub(crate) fn notify(&self) {
        self.0.notify();
    }

    /// From now on, receiving threads put messages into the port.
    pub(crate) fn start_live(&self, context: &LiveContext) {
        // never set twice: a system goes live once
        let _ = self.0.context.set(context.clone());
    }

    /// Moves the arrived messages into the port.
    pub(crate) fn deliver(&self, now: Time, effects: &mut dyn Effects) {
        self.0.drain(|| now, Ages::Ignored, effects);
    }
}

impl DeliveryGate {
    fn lock(&self) -> MutexGuard<'_, Option<TopicRoute>> {
        self.route.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Called by a thread of the bus after it has queued a message.
    fn notify(&self) {
        match self.context.get() {
            Some(context) => self.drain(|| context.now(), Ages::Counted, &mut context.clone()),
            None => self.notifier.notify(),
        }
    }

    /// Moves the queued messages into the port, or leaves that to the thread that is doing so.
    fn drain(&self, now: impl Fn() -> Time, ages: Ages, effects: &mut dyn Effects) {
        self.pending.swap(true, Ordering::AcqRel);
        fence(Ordering::SeqCst);
        loop {
            let mut route = match self.route.try_lock() {
                Ok(route) => route,
                Err(TryLockError::Poisoned(route)) => route.into_inner(),
                // the holder reads `pending` again after it has released the lock
                Err(TryLockError::WouldBlock) => return,
            };
            self.pending.swap(false, Ordering::AcqRel);
            if let Some(route) = &mut *route {
                route.drain(now(), ages, effects);
            }
            drop(route);
            fence(Ordering::SeqCst);
            if !self.pending.load(Ordering::Relaxed) {
                return;
            }
        }
    }
}

impl TopicRoute {
    fn drain(&mut self, now: Time, ages: Ages, effects: &mut dyn Effects) {
        let Some(mut port) = self.port.take() else {
            return;
        };
        self.report_discarded(&mut port, now, effects);
        while let Some(envelope) = self.subscription.try_next() {
            if self.own_incarnation == Some(envelope.incarnation) {
                continue;
            }
            match envelope.to_sample(&self.schema) {
                Ok(sample) => {
                    if let Some(trace) = envelope.trace {
                        self.cause.record(trace);
                    }
                    let written = match ages {
                        Ages::Counted => now - envelope.age,
                        Ages::Ignored => now,
                    };
                    let written = (&*envelope.source, written);
                    port.inject_written(&sample, written, now, effects);
                }
                Err(reason) => port.count_dropped(1, Some(&reason), now, effects),
            }
        }
        self.report_lost(&mut port, now, effects);
        self.port = Some(port);
    }
}

impl TopicRoute {
    /// Reports the messages that did not reach the port since the last call, by cause.
    fn report_lost(&mut self, port: &mut InjectionPort, now: Time, effects: &mut dyn Effects) {
        let now_lost = self.subscription.counts();
        let before = std::mem::replace(&mut self.lost, now_lost);
        let causes = [
            (now_lost.dropped, before.dropped, "the queue was full"),
            (
                now_lost.missed,
                before.missed,
                "their numbers are missing: the broker did not deliver them, as while an exchange or a queue does not exist",
            ),
            (
                now_lost.unreadable,
                before.unreadable,
                "their content cannot be decoded",
            ),
        ];
        for (count, before, reason) in causes {
            if count > before {
                let reason = DatumError::new(DatumProblem::Mismatch(reason.to_owned()));
                port.count_dropped(count - before, Some(&reason), now, effects);
            }
        }
    }

    /// Reports the messages that were sent before this process started, and waited for an earlier run of it.
    fn report_discarded(&mut self, port: &mut InjectionPort, now: Time, effects: &mut dyn Effects) {
        let discarded = self.subscription.counts().discarded;
        let new = discarded.saturating_sub(self.discarded);
        if new == 0 {
            return;
        }
        self.discarded = discarded;
        let reason =
            "they waited for an earlier run of this process, which ended without reading them";
        let reason = DatumError::new(DatumProblem::Mismatch(reason.to_owned()));
        port.count_dropped(new, Some(&reason), now, effects);
    }
}

/// Returns whether connections of these kinds have the same queue on a bus, so that one can take the messages of the other over
/// while a system runs.
pub fn has_same_queue(one: BufferKind, other: BufferKind) -> bool {
    queue_policy(one) == queue_policy(other)
}

/// The policy of the bus' queue for a port: only the newest message, if the connection keeps no more, and the same messages
/// of a full queue as the connection keeps.
fn queue_policy(kind: BufferKind) -> QueuePolicy {
    let (size, overflow) = match kind {
        BufferKind::Data => return QueuePolicy::Latest,
        BufferKind::Buffer(size) => (size, Overflow::DropNewest),
        BufferKind::Circular(size) => (size, Overflow::DropOldest),
    };
    let size = size.max(WAITING);
    QueuePolicy::All { size, overflow }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_written_queue_is_that_of_the_bus_too() {
        let all = |size, overflow| QueuePolicy::All { size, overflow };
        for (kind, expected) in [
            (BufferKind::Data, QueuePolicy::Latest),
            (BufferKind::Buffer(5000), all(5000, Overflow::DropNewest)),
            (BufferKind::Circular(5000), all(5000, Overflow::DropOldest)),
            // at least: the queue of the connection drops what is too much
            (BufferKind::Buffer(4), all(WAITING, Overflow::DropNewest)),
        ] {
            assert_eq!(queue_policy(kind), expected);
        }
    }
}
