//! A topic of the bus, on its way into a port.
//!
//! In a live system the thread that brings a message puts it into the port: no other thread is woken for it. In a
//! simulation messages come in between two steps, so there they wait for the adapter.

use std::sync::atomic::{AtomicBool, Ordering, fence};
use std::sync::{Arc, Mutex, OnceLock, PoisonError, TryLockError};

use asmotion_bus::{BusError, Notifier, Overflow, Pattern, QueuePolicy, Subscription};
use asmotion_datum::Schema;
use asmotion_port::{BufferKind, Policy, Time};
use asmotion_runtime::{ComponentEnd, CycleCause, Effects, InjectionPort, LiveContext, System};

use crate::identity::BusIdentity;

/// How many messages of a topic may wait to be put into their port, at least; when full, the oldest is dropped.
const WAITING: usize = 256;

/// A topic that a port reads. Each port has a queue of its own on the bus, so that none waits for another, and operators
/// see which one does not keep up.
pub(crate) struct TopicSubscription(Arc<DeliveryGate>);

/// Lets one thread at a time move messages from the bus's queue into the port, without ever blocking a thread.
///
/// Threads of the bus call [`notify`](Self::notify) after they have put a message into the queue; in a simulation the
/// executor's thread calls [`drain`](Self::drain). Several may come at once. The one that gets the lock drains the
/// queue; the others leave, and rely on it to see their messages. That is the hand-over:
///
/// 1. A thread sets `pending`, then tries the lock. If it fails, another thread holds the lock.
/// 2. The holder clears `pending` *after* it has the lock and *before* it drains, and looks at `pending` again *after* it
///    has released the lock.
///
/// A message is in the queue before its thread sets `pending`. If the holder clears the flag after that, its swap reads
/// what the thread's swap wrote, or a later swap of the same chain, so it sees the message when it drains. If it clears
/// the flag before that, it must see the flag when it looks again. This is the pattern of two threads that each write one
/// location and read the other (flag and lock here), and release and acquire do not order it; hence the two `SeqCst`
/// fences. Of the two fences one comes first. If it is the thread's, the holder's second look sees the flag. If it is the
/// holder's, the thread's attempt comes after the release, so it fails because of another holder, to which the same
/// applies. So no message stays behind.
///
/// A blocking lock would be simpler, but a thread of the bus would then wait for a port whose reader copies and converts.
struct DeliveryGate {
    /// Wakes the adapter.
    notifier: Arc<Notifier>,
    /// With which threads of the bus put messages into the port. Set once, by the bus thread before it starts; until then,
    /// and in a simulation always, they notify the adapter instead.
    context: OnceLock<LiveContext>,
    /// There may be messages that no thread is going to drain. See above.
    pending: AtomicBool,
    /// Absent until the topic is subscribed to.
    route: Mutex<Option<TopicRoute>>,
}

/// The route from a topic into a port.
struct TopicRoute {
    subscription: Subscription,
    port: InjectionPort,
    /// The port's type.
    schema: Schema,
    /// What the next cycle of the port's component follows from.
    cause: Arc<CycleCause>,
    /// Messages of this incarnation are the process's own, and were handed over inside.
    own: Option<u64>,
    /// How many messages have been counted as lost.
    lost: u64,
}

impl TopicSubscription {
    /// Subscribes to a topic of the bus for an input. Messages of the incarnation `own` do not come in. `None` if there can
    /// be no connection into the port, which joining has refused before.
    pub(crate) fn new(
        system: &mut System,
        topic: &str,
        input: &ComponentEnd,
        policy: &Policy,
        own: Option<u64>,
        identity: &BusIdentity,
    ) -> Result<Option<Self>, BusError> {
        let Some(port) = system.injection_port(input, policy) else {
            return Ok(None);
        };
        let gate = Arc::new(DeliveryGate {
            notifier: Arc::clone(&identity.notifier),
            context: OnceLock::new(),
            pending: AtomicBool::new(false),
            route: Mutex::default(),
        });
        // weak: the gate has the subscription, which has the notifier
        let notified = Arc::downgrade(&gate);
        let notifier = Notifier::calling(move || {
            if let Some(gate) = notified.upgrade() {
                gate.notify();
            }
        });
        let (bus, pattern) = (&identity.bus, Pattern::new(topic));
        let reader = system.component_of(input);
        let route = TopicRoute {
            subscription: bus.subscribe(
                &reader,
                &pattern,
                queue(policy.kind),
                Arc::new(notifier),
            )?,
            port,
            schema: system.input_schema(input).clone(),
            cause: system.cause_of(input),
            own,
            lost: 0,
        };
        *gate.route.lock().unwrap_or_else(PoisonError::into_inner) = Some(route);
        Ok(Some(Self(gate)))
    }

    /// From now on threads that bring messages put them into the port.
    pub(crate) fn go_live(&self, context: &LiveContext) {
        // a system goes live once
        let _ = self.0.context.set(context.clone());
    }

    /// Puts into the port what has come.
    pub(crate) fn deliver(&self, now: Time, effects: &mut dyn Effects) {
        self.0.drain(|| now, effects);
    }
}

impl DeliveryGate {
    /// A message has come.
    fn notify(&self) {
        match self.context.get() {
            Some(context) => self.drain(|| context.now(), &mut context.clone()),
            None => self.notifier.notify(),
        }
    }

    /// Puts into the port what has come, or leaves that to the thread that is doing so.
    fn drain(&self, now: impl Fn() -> Time, effects: &mut dyn Effects) {
        self.pending.swap(true, Ordering::AcqRel);
        fence(Ordering::SeqCst);
        loop {
            let mut route = match self.route.try_lock() {
                Ok(route) => route,
                Err(TryLockError::Poisoned(route)) => route.into_inner(),
                // the holder looks at `pending` again when it has released the lock
                Err(TryLockError::WouldBlock) => return,
            };
            self.pending.swap(false, Ordering::AcqRel);
            if let Some(route) = &mut *route {
                route.drain(now(), effects);
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
    fn drain(&mut self, now: Time, effects: &mut dyn Effects) {
        while let Some(envelope) = self.subscription.try_next() {
            if self.own == Some(envelope.incarnation) {
                continue;
            }
            match envelope.to_sample(&self.schema) {
                Ok(sample) => {
                    if let Some(trace) = envelope.trace {
                        self.cause.arrive(trace);
                    }
                    self.port.inject(&sample, now, effects);
                }
                Err(reason) => self.port.count_dropped(1, Some(&reason), now, effects),
            }
        }
        let received = self.subscription.received();
        let lost = received.dropped + received.missed + received.unreadable;
        if lost > self.lost {
            let more = lost - self.lost;
            self.lost = lost;
            self.port.count_dropped(more, None, now, effects);
        }
    }
}

/// The bus's queue for a port: the newest message, if the port's connection keeps only that.
fn queue(kind: BufferKind) -> QueuePolicy {
    match kind {
        BufferKind::Data => QueuePolicy::Latest,
        BufferKind::Buffer(size) | BufferKind::Circular(size) => QueuePolicy::All {
            size: size.max(WAITING),
            overflow: Overflow::DropOldest,
        },
    }
}
