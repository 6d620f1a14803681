//! The bus within one process: payloads are shared, and nothing is encoded. Publishers look up routes only after a
//! change.

use std::collections::BTreeMap;
use std::fmt;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError, Weak};
use std::time::Duration;

use asmotion_datum::Schema;

use crate::bus::{Bus, BusError, Publisher};
use crate::envelope::{Envelope, Payload};
use crate::health::{Health, LinkState};
use crate::pattern::Pattern;
use crate::publish_options::{PublishOptions, PublisherCounts};
use crate::queue::{QueuePolicy, Subscription, SubscriptionSender};
use crate::request::{AddressQueue, CallFailure, PendingCall, Request, ServedAddress};
use crate::sender_id::SenderId;
use crate::trace_context::{SpanGenerator, TraceContext};
use asmotion_connection::Notifier;

/// A bus inside one process. Clones are the same bus.
#[derive(Clone, Default)]
pub struct LocalBus {
    shared: Arc<LocalBusState>,
}

struct LocalBusState {
    routes: Mutex<Vec<LocalRoute>>,
    /// Incremented by every change of the routes, so that publishers look them up only then.
    generation: AtomicU64,
    addresses: Mutex<BTreeMap<String, Arc<AddressQueue>>>,
    /// Last messages of the publishers that retain one.
    retained: Mutex<Vec<Weak<Mutex<RetainedMessage>>>>,
    /// Always up.
    health: Health,
}

impl Default for LocalBusState {
    fn default() -> Self {
        Self {
            routes: Mutex::default(),
            generation: AtomicU64::new(0),
            addresses: Mutex::default(),
            retained: Mutex::default(),
            health: Health::now(LinkState::Up),
        }
    }
}

struct LocalRoute {
    pattern: Pattern,
    sender: SubscriptionSender,
    /// Generation in which this route was added.
    added_in: u64,
}

/// Last message of a publisher, and the routes that have received it.
#[derive(Default)]
struct RetainedMessage {
    envelope: Option<Envelope>,
    /// The generation up to which routes have received it.
    had: u64,
}

impl fmt::Debug for LocalBus {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "Local, {} subscriptions", self.shared.routes().len())
    }
}

impl LocalBus {
    /// Creates a bus without topics.
    pub fn new() -> Self {
        Self::default()
    }
}

impl LocalBusState {
    fn routes(&self) -> MutexGuard<'_, Vec<LocalRoute>> {
        self.routes.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn addresses(&self) -> MutexGuard<'_, BTreeMap<String, Arc<AddressQueue>>> {
        self.addresses
            .lock()
            .unwrap_or_else(PoisonError::into_inner)
    }

    fn retained(&self) -> MutexGuard<'_, Vec<Weak<Mutex<RetainedMessage>>>> {
        self.retained.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn change_routes(&self, change: impl FnOnce(&mut Vec<LocalRoute>, u64)) {
        let mut routes = self.routes();
        let next = self.generation.load(Ordering::Acquire) + 1;
        change(&mut routes, next);
        self.generation.store(next, Ordering::Release);
    }
}

impl Bus for LocalBus {
    fn publisher(
        &self,
        topic: &str,
        origin: &SenderId,
        schema: &Schema,
        sending: PublishOptions,
    ) -> Result<Box<dyn Publisher>, BusError> {
        let last = sending.init.then(Arc::<Mutex<RetainedMessage>>::default);
        let mut retained = self.shared.retained();
        retained.retain(|last| last.strong_count() > 0);
        retained.extend(last.as_ref().map(Arc::downgrade));
        drop(retained);
        Ok(Box::new(LocalPublisher {
            shared: Arc::clone(&self.shared),
            topic: topic.into(),
            spans: SpanGenerator::new(&origin.source, origin.incarnation, topic),
            origin: origin.clone(),
            type_name: (&*schema.name).into(),
            sequence: 0,
            unheard: 0,
            clock: "".into(),
            generation: u64::MAX,
            senders: Vec::new(),
            retained: last,
        }))
    }

    fn subscribe(
        &self,
        _: &str,
        pattern: &Pattern,
        queue: QueuePolicy,
        notifier: Arc<Notifier>,
    ) -> Result<Subscription, BusError> {
        let sender = SubscriptionSender::new(queue, notifier);
        self.shared.change_routes(|routes, since| {
            routes.push(LocalRoute {
                pattern: pattern.clone(),
                sender: sender.clone(),
                added_in: since,
            });
        });
        let (shared, own) = (Arc::clone(&self.shared), sender.clone());
        Ok(sender.subscription(move || {
            shared.change_routes(|routes, _| routes.retain(|route| !route.sender.is_same(&own)));
        }))
    }

    fn serve(
        &self,
        address: &str,
        size: usize,
        notifier: Arc<Notifier>,
    ) -> Result<ServedAddress, BusError> {
        let mut desks = self.shared.addresses();
        if desks.contains_key(address) {
            return Err(BusError::Served {
                address: address.to_owned(),
            });
        }
        let queue = AddressQueue::new(size, notifier);
        desks.insert(address.to_owned(), Arc::clone(&queue));
        let (shared, address) = (Arc::clone(&self.shared), address.to_owned());
        Ok(ServedAddress::new(queue, move || {
            shared.addresses().remove(&address);
        }))
    }

    fn call(
        &self,
        address: &str,
        request: Request,
        notifier: Arc<Notifier>,
    ) -> Result<PendingCall, BusError> {
        let queue = self.shared.addresses().get(address).cloned();
        let (pending, call) = PendingCall::new(request, notifier);
        match queue {
            // if the queue rejects the call, it also ends it
            Some(desk) => drop(desk.push(call)),
            None => call.complete(Err(CallFailure::Unavailable)),
        }
        Ok(pending)
    }

    fn call_one_way(
        &self,
        address: &str,
        request: Request,
        notifier: Arc<Notifier>,
    ) -> Result<PendingCall, BusError> {
        let queue = self.shared.addresses().get(address).cloned();
        let (pending, call, delivered) = PendingCall::one_way(request, notifier);
        delivered.complete(match queue {
            Some(desk) => desk.push(call),
            None => Err(CallFailure::Unavailable),
        });
        Ok(pending)
    }

    fn republish_retained(&self) {
        let routes = self.shared.routes();
        let now = self.shared.generation.load(Ordering::Acquire);
        for last in self.shared.retained().iter().filter_map(Weak::upgrade) {
            let mut last = last.lock().unwrap_or_else(PoisonError::into_inner);
            let had = std::mem::replace(&mut last.had, now);
            let Some(envelope) = &last.envelope else {
                continue;
            };
            for route in routes.iter().filter(|route| route.added_in > had) {
                if route.pattern.matches(&envelope.topic) {
                    route.sender.push(envelope.clone());
                }
            }
        }
    }

    fn health(&self) -> Health {
        self.shared.health.clone()
    }

    /// Does nothing: the health of a local bus never changes.
    fn notify_on_change(&self, _: &Arc<Notifier>) {}

    /// Returns `true` at once: local messages are delivered when they are published.
    fn drain(&self, _: Duration) -> bool {
        true
    }
}

struct LocalPublisher {
    shared: Arc<LocalBusState>,
    topic: Arc<str>,
    spans: SpanGenerator,
    origin: SenderId,
    type_name: Arc<str>,
    /// Number of the newest message.
    sequence: u64,
    /// Number of messages without a subscription.
    unheard: u64,
    /// Empty: the reader's own clock.
    clock: Arc<str>,
    /// Generation of the routes at which `senders` was looked up.
    generation: u64,
    /// Matching subscriptions.
    senders: Vec<SubscriptionSender>,
    /// The last message, if it is retained.
    retained: Option<Arc<Mutex<RetainedMessage>>>,
}

impl Publisher for LocalPublisher {
    fn publish_traced(
        &mut self,
        stamp: i64,
        payload: Payload,
        cause: Option<TraceContext>,
    ) -> Result<(), BusError> {
        let generation = self.shared.generation.load(Ordering::Acquire);
        if generation != self.generation {
            let routes = self.shared.routes();
            let matching = routes
                .iter()
                .filter(|route| route.pattern.matches(&self.topic));
            self.senders = matching.map(|route| route.sender.clone()).collect();
            self.generation = generation;
        }
        self.sequence += 1;
        self.unheard += u64::from(self.senders.is_empty());
        let trace = self.spans.of(self.sequence, cause);
        let envelope = Envelope {
            topic: Arc::clone(&self.topic),
            source: Arc::clone(&self.origin.source),
            incarnation: self.origin.incarnation,
            sequence: self.sequence,
            stamp,
            age: Duration::ZERO,
            clock: Arc::clone(&self.clock),
            trace: Some(trace),
            type_name: Arc::clone(&self.type_name),
            payload,
        };
        for sender in &self.senders {
            sender.push(envelope.clone());
        }
        if let Some(last) = &self.retained {
            *last.lock().unwrap_or_else(PoisonError::into_inner) = RetainedMessage {
                envelope: Some(envelope),
                had: self.generation,
            };
        }
        Ok(())
    }

    fn counts(&self) -> PublisherCounts {
        PublisherCounts {
            published: self.sequence,
            accepted: self.sequence,
            unrouted: self.unheard,
            ..PublisherCounts::default()
        }
    }
}
