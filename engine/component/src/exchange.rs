//! The exchange: the system's topics on a bus. What is published inside goes out, what others publish comes in.

use std::sync::Arc;
use std::time::Duration;

use bus::{
    Bell, Bus, BusError, Origin, Overflow, Pattern, Payload, Publisher, Queue, Sending,
    Subscription,
};
use datum::{DatumError, Problem, Sample};

use crate::Time;
use crate::connection::Delivery;
use crate::door::{Doors, Place};
use crate::outside::Outside;
use crate::port::{AnySender, Link};
use crate::system::Topic;
use crate::unit::Unit;

/// How many messages of a topic may wait between two deliveries; when full, the oldest is dropped.
const WAITING: usize = 256;

/// The system's side of a bus.
pub(crate) struct Exchange {
    /// Which life of the system's process: what it has published itself does not come in again.
    incarnation: u64,
    doors: Doors,
    subscriptions: Vec<(Place, Subscription)>,
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
        let mut subscriptions = Vec::new();
        for (index, topic) in topics.iter().enumerate() {
            for end in &topic.publishers {
                publish(
                    &mut units[end.unit],
                    end.index,
                    &topic.name,
                    bus,
                    incarnation,
                )?;
            }
            if !topic.subscribers.is_empty() {
                let pattern = Pattern::new(&*topic.name);
                let queue = Queue::All {
                    size: WAITING,
                    overflow: Overflow::DropOldest,
                };
                let subscription = bus.subscribe(&pattern, queue, Arc::clone(&bell))?;
                subscriptions.push((Place::Topic(index), subscription));
            }
        }
        Ok(Self {
            incarnation,
            doors: Doors::new(units, topics),
            subscriptions,
            bell,
        })
    }

    /// Lets in what has come.
    pub(crate) fn deliver(&mut self, now: Time, outside: &mut dyn Outside) {
        for (place, subscription) in &self.subscriptions {
            while let Some(envelope) = subscription.try_next() {
                if envelope.incarnation == self.incarnation {
                    continue;
                }
                match envelope.payload.to_sample() {
                    Ok(sample) => self.doors.give(*place, &sample, now, outside),
                    Err(reason) => self.doors.refuse(*place, &reason, now, outside),
                }
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

/// Lets an output publish on the bus too.
fn publish(
    unit: &mut Unit,
    output: usize,
    topic: &str,
    bus: &dyn Bus,
    incarnation: u64,
) -> Result<(), BusError> {
    let origin = Origin::new(Arc::clone(&unit.name), incarnation);
    let output = &mut unit.body.outputs[output];
    let type_name = output.schema().name.clone();
    let publisher = bus.publisher(topic, &origin, &type_name, Sending::default())?;
    output.join(
        Box::new(BusSender(publisher)),
        Link::to_bus(format!("bus topic {topic}")),
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
