//! The exchange: the system's topics on a bus. What is published inside goes out, what others publish comes in.

use std::sync::Arc;
use std::time::Duration;

use bus::{
    Bell, Bus, BusError, Origin, Overflow, Pattern, Payload, Publisher, Queue, Subscription,
};
use datum::{DatumError, Problem, Sample};

use crate::connection::Delivery;
use crate::door::{Doors, Place};
use crate::outside::Outside;
use crate::port::{AnySender, Link};
use crate::system::Topic;
use crate::unit::Unit;
use crate::{Kind, Time};

/// How many messages of a topic may wait between two deliveries, at least; when full, the oldest is dropped.
const WAITING: usize = 256;

/// A topic of the bus, on its way in.
struct Incoming {
    place: Place,
    subscription: Subscription,
    /// How many of its messages are known to be lost.
    lost: u64,
}

/// The system's side of a bus.
pub(crate) struct Exchange {
    /// Which life of the system's process: what it has published itself does not come in again.
    incarnation: u64,
    doors: Doors,
    incoming: Vec<Incoming>,
    bell: Arc<Bell>,
}

impl Exchange {
    /// Joins the system's topics to those of the bus.
    pub(crate) fn new(
        units: &mut [Unit],
        topics: &[Topic],
        bus: &dyn Bus,
        incarnation: u64,
    ) -> Result<Self, BusError> {
        let bell = Arc::new(Bell::new());
        let mut incoming = Vec::new();
        for (index, topic) in topics.iter().enumerate() {
            for end in &topic.publishers {
                publish(&mut units[end.unit], end.index, topic, bus, incarnation)?;
            }
            if !topic.subscribers.is_empty() {
                let pattern = Pattern::new(&*topic.name);
                let subscription = bus.subscribe(&pattern, queue(topic), Arc::clone(&bell))?;
                incoming.push(Incoming {
                    place: Place::Topic(index),
                    subscription,
                    lost: 0,
                });
            }
        }
        Ok(Self {
            incarnation,
            doors: Doors::new(units, topics),
            incoming,
            bell,
        })
    }

    /// Lets in what has come.
    pub(crate) fn deliver(&mut self, now: Time, outside: &mut dyn Outside) {
        for topic in &mut self.incoming {
            while let Some(envelope) = topic.subscription.try_next() {
                if envelope.incarnation == self.incarnation {
                    continue;
                }
                match envelope.payload.to_sample() {
                    Ok(sample) => self.doors.give(topic.place, &sample, now, outside),
                    Err(reason) => self.doors.refuse(topic.place, &reason, now, outside),
                }
            }
            let received = topic.subscription.received();
            let lost = received.dropped + received.missed + received.unreadable;
            if lost > topic.lost {
                let more = lost - topic.lost;
                topic.lost = lost;
                self.doors.lose(topic.place, more, now, outside);
            }
        }
    }

    /// Waits until something has come, or so long.
    pub(crate) fn wait(&self, at_most: Duration) {
        self.bell.wait(at_most);
    }

    /// The bell that ends a wait.
    pub(crate) fn bell(&self) -> Arc<Bell> {
        Arc::clone(&self.bell)
    }
}

/// What the bus keeps of a topic for us: where every reader wants the newest, the newest.
fn queue(topic: &Topic) -> Queue {
    let sizes = topic
        .subscribers
        .iter()
        .map(|(_, policy)| match policy.kind {
            Kind::Data => None,
            Kind::Buffer(size) | Kind::Circular(size) => Some(size),
        });
    match sizes.max().flatten() {
        None => Queue::Latest,
        Some(size) => Queue::All {
            size: size.max(WAITING),
            overflow: Overflow::DropOldest,
        },
    }
}

/// Lets an output publish on the bus too.
fn publish(
    unit: &mut Unit,
    output: usize,
    topic: &Topic,
    bus: &dyn Bus,
    incarnation: u64,
) -> Result<(), BusError> {
    let origin = Origin::new(Arc::clone(&unit.name), incarnation);
    let output = &mut unit.body.outputs[output];
    let type_name = output.schema().name.clone();
    let publisher = bus.publisher(&topic.name, &origin, &type_name, topic.sending)?;
    output.join(
        Box::new(BusSender(publisher)),
        Link::to_bus(format!("bus topic {}", topic.name)),
    );
    Ok(())
}

/// The bus as the reading end of a connection.
struct BusSender(Box<dyn Publisher>);

impl AnySender for BusSender {
    fn accepts(&self, _: &Arc<dyn Sample>) -> Result<(), DatumError> {
        Ok(())
    }

    fn send_sample(
        &mut self,
        sample: Arc<dyn Sample>,
        at: Time,
        _: u64,
    ) -> Result<Delivery, DatumError> {
        match self.0.publish(at.nanos(), Payload::Sample(sample)) {
            Ok(()) => Ok(Delivery::Stored),
            Err(error) => Err(DatumError::new(Problem::Mismatch(error.to_string()))),
        }
    }
}
