//! The bus inside one process: payloads are shared, nothing is encoded; publishing looks at the routes only when they
//! have changed.

use std::collections::BTreeMap;
use std::fmt;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError, Weak};
use std::time::Duration;

use asmotion_datum::Schema;

use crate::request::Desk;
use crate::{
    Bus, BusError, CallFailure, Envelope, Health, Inlet, Link, Notifier, Origin, Pattern, Payload,
    Pending, Publisher, Queue, Request, Sending, Sent, Serving, Spans, Subscription, Trace,
};

/// A bus inside one process. Clones are the same bus.
#[derive(Clone, Default)]
pub struct Local {
    shared: Arc<Shared>,
}

struct Shared {
    routes: Mutex<Vec<Route>>,
    /// Grows with every change of the routes, so that publishers look at them only then.
    generation: AtomicU64,
    desks: Mutex<BTreeMap<String, Arc<Desk>>>,
    /// Of publishers that keep it, the last message.
    lasts: Mutex<Vec<Weak<Mutex<Last>>>>,
    /// Up from the beginning to the end.
    health: Health,
}

impl Default for Shared {
    fn default() -> Self {
        Self {
            routes: Mutex::default(),
            generation: AtomicU64::new(0),
            desks: Mutex::default(),
            lasts: Mutex::default(),
            health: Health::now(Link::Up),
        }
    }
}

struct Route {
    pattern: Pattern,
    inlet: Inlet,
    /// The generation that it came with.
    since: u64,
}

/// The last message of a publisher, and who has it.
#[derive(Default)]
struct Last {
    envelope: Option<Envelope>,
    /// The routes up to this generation.
    had: u64,
}

impl fmt::Debug for Local {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "Local, {} subscriptions", self.shared.routes().len())
    }
}

impl Local {
    /// A bus without topics.
    pub fn new() -> Self {
        Self::default()
    }
}

impl Shared {
    fn routes(&self) -> MutexGuard<'_, Vec<Route>> {
        self.routes.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn desks(&self) -> MutexGuard<'_, BTreeMap<String, Arc<Desk>>> {
        self.desks.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn lasts(&self) -> MutexGuard<'_, Vec<Weak<Mutex<Last>>>> {
        self.lasts.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn change_routes(&self, change: impl FnOnce(&mut Vec<Route>, u64)) {
        let mut routes = self.routes();
        let next = self.generation.load(Ordering::Acquire) + 1;
        change(&mut routes, next);
        self.generation.store(next, Ordering::Release);
    }
}

impl Bus for Local {
    fn publisher(
        &self,
        topic: &str,
        origin: &Origin,
        schema: &Schema,
        sending: Sending,
    ) -> Result<Box<dyn Publisher>, BusError> {
        let last = sending.init.then(Arc::<Mutex<Last>>::default);
        let mut lasts = self.shared.lasts();
        lasts.retain(|last| last.strong_count() > 0);
        lasts.extend(last.as_ref().map(Arc::downgrade));
        drop(lasts);
        Ok(Box::new(LocalPublisher {
            shared: Arc::clone(&self.shared),
            topic: topic.into(),
            spans: Spans::new(&origin.source, origin.incarnation, topic),
            origin: origin.clone(),
            type_name: (&*schema.name).into(),
            sequence: 0,
            unheard: 0,
            clock: "".into(),
            generation: u64::MAX,
            inlets: Vec::new(),
            last,
        }))
    }

    fn subscribe(
        &self,
        _: &str,
        pattern: &Pattern,
        queue: Queue,
        notifier: Arc<Notifier>,
    ) -> Result<Subscription, BusError> {
        let inlet = Inlet::new(queue, notifier);
        self.shared.change_routes(|routes, since| {
            routes.push(Route {
                pattern: pattern.clone(),
                inlet: inlet.clone(),
                since,
            });
        });
        let (shared, own) = (Arc::clone(&self.shared), inlet.clone());
        Ok(inlet.subscription(move || {
            shared.change_routes(|routes, _| routes.retain(|route| !route.inlet.is_same(&own)));
        }))
    }

    fn serve(
        &self,
        address: &str,
        size: usize,
        notifier: Arc<Notifier>,
    ) -> Result<Serving, BusError> {
        let mut desks = self.shared.desks();
        if desks.contains_key(address) {
            return Err(BusError::Served {
                address: address.to_owned(),
            });
        }
        let desk = Desk::new(size, notifier);
        desks.insert(address.to_owned(), Arc::clone(&desk));
        let (shared, address) = (Arc::clone(&self.shared), address.to_owned());
        Ok(Serving::new(desk, move || {
            shared.desks().remove(&address);
        }))
    }

    fn call(
        &self,
        address: &str,
        request: Request,
        notifier: Arc<Notifier>,
    ) -> Result<Pending, BusError> {
        let desk = self.shared.desks().get(address).cloned();
        let (pending, call) = Pending::new(request, notifier);
        match desk {
            // What the desk refuses, it ends.
            Some(desk) => drop(desk.put(call)),
            None => call.end(Err(CallFailure::Unavailable)),
        }
        Ok(pending)
    }

    fn tell(
        &self,
        address: &str,
        request: Request,
        notifier: Arc<Notifier>,
    ) -> Result<Pending, BusError> {
        let desk = self.shared.desks().get(address).cloned();
        let (pending, call, delivered) = Pending::one_way(request, notifier);
        delivered.end(match desk {
            Some(desk) => desk.put(call),
            None => Err(CallFailure::Unavailable),
        });
        Ok(pending)
    }

    fn repeat(&self) {
        let routes = self.shared.routes();
        let now = self.shared.generation.load(Ordering::Acquire);
        for last in self.shared.lasts().iter().filter_map(Weak::upgrade) {
            let mut last = last.lock().unwrap_or_else(PoisonError::into_inner);
            let had = std::mem::replace(&mut last.had, now);
            let Some(envelope) = &last.envelope else {
                continue;
            };
            for route in routes.iter().filter(|route| route.since > had) {
                if route.pattern.matches(&envelope.topic) {
                    route.inlet.push(envelope.clone());
                }
            }
        }
    }

    fn health(&self) -> Health {
        self.shared.health.clone()
    }

    /// It never changes.
    fn watch(&self, _: &Arc<Notifier>) {}

    /// What is published has arrived.
    fn drain(&self, _: Duration) -> bool {
        true
    }
}

struct LocalPublisher {
    shared: Arc<Shared>,
    topic: Arc<str>,
    spans: Spans,
    origin: Origin,
    type_name: Arc<str>,
    /// Number of the last message.
    sequence: u64,
    /// How many found no subscription.
    unheard: u64,
    /// The reader's own.
    clock: Arc<str>,
    /// The routes that `inlets` was made from.
    generation: u64,
    /// The subscriptions that match.
    inlets: Vec<Inlet>,
    /// The last message, if it is kept.
    last: Option<Arc<Mutex<Last>>>,
}

impl Publisher for LocalPublisher {
    fn publish_within(
        &mut self,
        stamp: i64,
        payload: Payload,
        cause: Option<Trace>,
    ) -> Result<(), BusError> {
        let generation = self.shared.generation.load(Ordering::Acquire);
        if generation != self.generation {
            let routes = self.shared.routes();
            let matching = routes
                .iter()
                .filter(|route| route.pattern.matches(&self.topic));
            self.inlets = matching.map(|route| route.inlet.clone()).collect();
            self.generation = generation;
        }
        self.sequence += 1;
        self.unheard += u64::from(self.inlets.is_empty());
        let trace = self.spans.of(self.sequence, cause);
        let envelope = Envelope {
            topic: Arc::clone(&self.topic),
            source: Arc::clone(&self.origin.source),
            incarnation: self.origin.incarnation,
            sequence: self.sequence,
            stamp,
            clock: Arc::clone(&self.clock),
            trace: Some(trace),
            type_name: Arc::clone(&self.type_name),
            payload,
        };
        for inlet in &self.inlets {
            inlet.push(envelope.clone());
        }
        if let Some(last) = &self.last {
            *last.lock().unwrap_or_else(PoisonError::into_inner) = Last {
                envelope: Some(envelope),
                had: self.generation,
            };
        }
        Ok(())
    }

    fn sent(&self) -> Sent {
        Sent {
            published: self.sequence,
            arrived: self.sequence,
            unheard: self.unheard,
            ..Sent::default()
        }
    }
}
