//! Topics on the bus: what is published inside goes out, what others publish comes in.

use std::sync::Arc;

use asmotion_bus::{Bus, BusError, Origin, Payload, Publisher, Sending};
use asmotion_connection::Delivery;
use asmotion_datum::{DatumError, Problem, Sample};

use super::Membership;
use super::incoming::Incoming;
use crate::Time;
use crate::cause::Cause;
use crate::door::Doors;
use crate::health::{HEALTH_TOPIC, HealthTeller};
use crate::live::World;
use crate::outside::Outside;
use crate::port::{AnySender, Link};
use crate::system::{End, Joints, Topic, port_topic};
use crate::unit::Unit;

/// The system's topics, as they are on the bus.
pub(super) struct Topics {
    incoming: Vec<Incoming>,
    health: HealthTeller,
    /// Those of the topic of health.
    doors: Doors,
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
        let own = (!abroad).then_some(membership.incarnation);
        let is_health = |topic: &&Topic| topic.name == HEALTH_TOPIC;
        let mut incoming = Vec::new();
        for topic in topics.iter().filter(|topic| !is_health(topic)) {
            for (end, policy) in &topic.subscribers {
                let input = (&mut units[end.unit], end.index);
                let number = joints.number();
                let made = Incoming::new(&topic.name, input, policy, number, own, membership)?;
                incoming.extend(made);
            }
        }
        let health: Vec<Topic> = topics
            .iter()
            .filter(is_health)
            .map(|it| it.of(|_| true))
            .collect();
        Ok(Self {
            incoming,
            health: HealthTeller::new(&health),
            doors: Doors::of_topics(units, &health, joints),
            bus: Arc::clone(&membership.bus),
        })
    }

    /// From now on what comes is let in by the thread that brings it.
    pub(super) fn go_live(&self, world: &World) {
        for incoming in &self.incoming {
            incoming.go_live(world);
        }
    }

    /// Lets in what has come, and tells how the bus is.
    pub(super) fn deliver(&mut self, now: Time, outside: &mut dyn Outside) {
        let bus = &self.bus;
        (self.health).tell(|| bus.health(), &mut self.doors, now, outside);
        for incoming in &self.incoming {
            incoming.deliver(now, outside);
        }
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
