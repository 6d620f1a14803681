//! Topics on the bus: what is published inside goes out, what others publish comes in.

use std::sync::Arc;

use bus::{
    Bus, BusError, Origin, Overflow, Pattern, Payload, Publisher, Queue, Sending, Subscription,
};
use connection::Delivery;
use datum::{DatumError, Problem, Sample, Schema};

use super::Membership;
use crate::cause::Cause;
use crate::door::{Doors, Place};
use crate::health::{HEALTH_TOPIC, HealthTeller};
use crate::outside::Outside;
use crate::port::{AnySender, Link};
use crate::system::{End, Joints, Topic, port_topic};
use crate::unit::Unit;
use crate::{Kind, Time};

/// How many messages of a topic may wait between two deliveries, at least; when full, the oldest is dropped.
const WAITING: usize = 256;

/// A topic of the bus, on its way into a port. Each port that reads it has a queue of its own there, so that none waits
/// for another, and operators see who does not keep up.
struct Incoming {
    place: Place,
    /// What the port takes.
    schema: Schema,
    /// What the next cycle of its component follows from.
    cause: Arc<Cause>,
    subscription: Subscription,
    /// How many of its messages are known to be lost.
    lost: u64,
}

/// The system's topics, as they are on the bus.
pub(super) struct Topics {
    /// What carries it is our own, and does not come in again: it was handed over inside.
    own: Option<u64>,
    doors: Doors,
    incoming: Vec<Incoming>,
    health: HealthTeller,
    bus: Arc<dyn Bus>,
}

impl Topics {
    /// Joins topics, and outputs that others are connected to. Topics that are `abroad` come in even if they are our own.
    pub(super) fn new<'e>(
        units: &mut [Unit],
        topics: &[Topic],
        joints: &mut Joints,
        exposed: impl Iterator<Item = &'e (End, Sending)>,
        abroad: bool,
        membership: &Membership,
    ) -> Result<Self, BusError> {
        for topic in topics {
            for end in &topic.publishers {
                publish(units, end, &topic.name, topic.sending, membership)?;
            }
        }
        for (end, sending) in exposed {
            publish(units, end, &port_topic(&end.name), *sending, membership)?;
        }
        let doors = Doors::of_topics(units, topics, joints);
        let mut incoming = Vec::new();
        for (index, topic) in topics.iter().enumerate() {
            if topic.name == HEALTH_TOPIC {
                continue;
            }
            let pattern = Pattern::new(&*topic.name);
            for (end, policy) in &topic.subscribers {
                let Some(place) = doors.reader(index, &end.name) else {
                    continue;
                };
                let unit = &units[end.unit];
                let bell = Arc::clone(&membership.bell);
                let queue = queue(policy.kind);
                incoming.push(Incoming {
                    place,
                    cause: Arc::clone(&unit.body.cause),
                    schema: unit.body.inputs[end.index].schema().clone(),
                    subscription: (membership.bus).subscribe(&unit.name, &pattern, queue, bell)?,
                    lost: 0,
                });
            }
        }
        Ok(Self {
            own: (!abroad).then_some(membership.incarnation),
            doors,
            incoming,
            health: HealthTeller::new(topics),
            bus: Arc::clone(&membership.bus),
        })
    }

    /// Lets in what has come, and tells how the bus is.
    pub(super) fn deliver(&mut self, now: Time, outside: &mut dyn Outside) {
        let bus = &self.bus;
        (self.health).tell(|| bus.health(), &mut self.doors, now, outside);
        for topic in &mut self.incoming {
            while let Some(envelope) = topic.subscription.try_next() {
                if self.own == Some(envelope.incarnation) {
                    continue;
                }
                match envelope.to_sample(&topic.schema) {
                    Ok(sample) => {
                        if let Some(trace) = envelope.trace {
                            topic.cause.arrive(trace);
                        }
                        self.doors.give(topic.place, &sample, now, outside);
                    }
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

/// Lets an output publish on the bus too.
fn publish(
    units: &mut [Unit],
    end: &End,
    topic: &str,
    sending: Sending,
    membership: &Membership,
) -> Result<(), BusError> {
    let unit = &mut units[end.unit];
    let origin = Origin::new(Arc::clone(&unit.name), membership.incarnation);
    let cause = Arc::clone(&unit.body.cause);
    let output = &mut unit.body.outputs[end.index];
    let publisher = (membership.bus).publisher(topic, &origin, output.schema(), sending)?;
    output.join(
        Box::new(BusSender { publisher, cause }),
        Link::to_bus(format!("bus topic {topic}")),
    );
    Ok(())
}

/// The bus as the reading end of a connection.
struct BusSender {
    publisher: Box<dyn Publisher>,
    /// What the component's present cycle follows from.
    cause: Arc<Cause>,
}

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
        let payload = Payload::Sample(sample);
        let cause = self.cause.present();
        match (self.publisher).publish_within(at.nanos(), payload, cause) {
            Ok(()) => Ok(Delivery::Stored),
            Err(error) => Err(DatumError::new(Problem::Mismatch(error.to_string()))),
        }
    }
}
