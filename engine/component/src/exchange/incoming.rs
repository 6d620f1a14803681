//! A topic of the bus, on its way into a port.
//!
//! In a live system the thread that brings a message puts it into the port: nobody else is woken for it. In a simulation
//! messages come in between two steps, so there they wait for the exchange.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, OnceLock, PoisonError, TryLockError};

use asmotion_bus::{Bell, BusError, Overflow, Pattern, Queue, Subscription};
use asmotion_datum::Schema;

use super::Membership;
use crate::cause::Cause;
use crate::door::Door;
use crate::live::World;
use crate::outside::Outside;
use crate::system::ConnectionId;
use crate::unit::Unit;
use crate::{Kind, Policy, Time};

/// How many messages of a topic may wait to be let in, at least; when full, the oldest is dropped.
const WAITING: usize = 256;

/// A topic that a port reads. Each port has a queue of its own on the bus, so that none waits for another, and operators
/// see who does not keep up.
pub(super) struct Incoming(Arc<Gate>);

/// Where messages come in, one after another, whoever brings them.
struct Gate {
    /// Wakes the exchange.
    bell: Arc<Bell>,
    /// Where those who bring messages let them in; as long as there is none, the exchange alone does.
    world: OnceLock<World>,
    /// There may be something that nobody has let in.
    knocked: AtomicBool,
    /// Nothing, until the topic is subscribed to.
    way: Mutex<Option<Way>>,
}

/// The way from a topic into a port.
struct Way {
    subscription: Subscription,
    door: Door,
    /// What the port takes.
    schema: Schema,
    /// What the next cycle of its component follows from.
    cause: Arc<Cause>,
    /// What carries it is our own, and does not come in again: it was handed over inside.
    own: Option<u64>,
    /// How many messages are known to be lost.
    lost: u64,
}

impl Incoming {
    /// Subscribes to a topic of the bus for an input of a component. `own` is what does not come in. Where there can be
    /// no way into the port, which joining has refused before, there is none.
    pub(super) fn new(
        topic: &str,
        (unit, input): (&mut Unit, usize),
        policy: &Policy,
        connection: ConnectionId,
        own: Option<u64>,
        membership: &Membership,
    ) -> Result<Option<Self>, BusError> {
        let Some(door) = Door::open(unit, input, policy, connection) else {
            return Ok(None);
        };
        let gate = Arc::new(Gate {
            bell: Arc::clone(&membership.bell),
            world: OnceLock::new(),
            knocked: AtomicBool::new(false),
            way: Mutex::default(),
        });
        let knocking = Arc::downgrade(&gate);
        let bell = Bell::that(move || {
            if let Some(gate) = knocking.upgrade() {
                gate.knock();
            }
        });
        let (bus, pattern) = (&membership.bus, Pattern::new(topic));
        let queue = queue(policy.kind);
        let way = Way {
            subscription: bus.subscribe(&unit.name, &pattern, queue, Arc::new(bell))?,
            door,
            schema: unit.body.inputs[input].schema().clone(),
            cause: Arc::clone(&unit.body.cause),
            own,
            lost: 0,
        };
        *gate.way.lock().unwrap_or_else(PoisonError::into_inner) = Some(way);
        Ok(Some(Self(gate)))
    }

    /// From now on those who bring messages let them in.
    pub(super) fn go_live(&self, world: &World) {
        // a system goes live once
        let _ = self.0.world.set(world.clone());
    }

    /// Lets in what has come.
    pub(super) fn deliver(&self, now: Time, outside: &mut dyn Outside) {
        self.0.let_in(|| now, outside);
    }
}

impl Gate {
    /// Something has come.
    fn knock(&self) {
        match self.world.get() {
            Some(world) => self.let_in(|| world.now(), &mut world.clone()),
            None => self.bell.ring(),
        }
    }

    /// Lets in what has come, or leaves it to who is in the way already: nobody waits, and nothing stays behind.
    fn let_in(&self, now: impl Fn() -> Time, outside: &mut dyn Outside) {
        self.knocked.store(true, Ordering::SeqCst);
        while self.knocked.load(Ordering::SeqCst) {
            let mut way = match self.way.try_lock() {
                Ok(way) => way,
                Err(TryLockError::Poisoned(way)) => way.into_inner(),
                // who is in it looks again when it has left it
                Err(TryLockError::WouldBlock) => return,
            };
            self.knocked.store(false, Ordering::SeqCst);
            if let Some(way) = &mut *way {
                way.let_in(now(), outside);
            }
        }
    }
}

impl Way {
    fn let_in(&mut self, now: Time, outside: &mut dyn Outside) {
        while let Some(envelope) = self.subscription.try_next() {
            if self.own == Some(envelope.incarnation) {
                continue;
            }
            match envelope.to_sample(&self.schema) {
                Ok(sample) => {
                    if let Some(trace) = envelope.trace {
                        self.cause.arrive(trace);
                    }
                    self.door.let_in(&sample, now, outside);
                }
                Err(reason) => self.door.drop_some(1, Some(&reason), now, outside),
            }
        }
        let received = self.subscription.received();
        let lost = received.dropped + received.missed + received.unreadable;
        if lost > self.lost {
            let more = lost - self.lost;
            self.lost = lost;
            self.door.drop_some(more, None, now, outside);
        }
    }
}

/// What the bus keeps of a topic for a port: where it wants the newest, the newest.
fn queue(kind: Kind) -> Queue {
    match kind {
        Kind::Data => Queue::Latest,
        Kind::Buffer(size) | Kind::Circular(size) => Queue::All {
            size: size.max(WAITING),
            overflow: Overflow::DropOldest,
        },
    }
}
