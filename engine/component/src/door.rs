//! Doors: ways into input ports for those outside of the system, and the topics as seen from there.

use std::sync::Arc;

use asmotion_connection::Delivery;
use asmotion_datum::{DatumError, Sample};

use crate::outside::Outside;
use crate::port::AnySender;
use crate::property::suggestion_among;
use crate::run::RunError;
use crate::system::{ConnectionId, Joints, Topic};
use crate::unit::Unit;
use crate::{Event, Policy, Time};

/// How many samples from outside may wait at a port for its component's next cycle.
const WAITING: usize = 64;

/// A way into one input port.
pub(crate) struct Door {
    /// `Component.port`.
    name: String,
    component: usize,
    /// Whether samples trigger the component.
    trigger: bool,
    /// The type it takes.
    expected: String,
    sender: Box<dyn AnySender>,
    dropped: u64,
}

/// All doors of a system.
pub(crate) struct Doors {
    /// One for each input.
    ports: Vec<Door>,
    /// For each topic those of its subscribers, as they want to be served.
    topics: Vec<(String, Vec<Door>)>,
}

/// Where a sample from outside goes.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Place {
    Port(usize),
    /// All who read a topic.
    Topic(usize),
}

impl Doors {
    pub(crate) fn new(units: &mut [Unit], topics: &[Topic], joints: &mut Joints) -> Self {
        let mut ports = Vec::new();
        for unit in &mut *units {
            let inputs = unit.body.inputs.len();
            let policy = Policy::buffer(WAITING);
            ports.extend(
                (0..inputs).filter_map(|index| Door::open(unit, index, &policy, joints.number())),
            );
        }
        Self {
            ports,
            ..Self::of_topics(units, topics, joints)
        }
    }

    /// The doors of topics alone.
    pub(crate) fn of_topics(units: &mut [Unit], topics: &[Topic], joints: &mut Joints) -> Self {
        let topics = topics
            .iter()
            .map(|topic| {
                let doors = topic.subscribers.iter().filter_map(|(end, policy)| {
                    let unit = units.get_mut(end.unit)?;
                    Door::open(unit, end.index, policy, joints.number())
                });
                (topic.name.clone(), doors.collect())
            })
            .collect();
        Self {
            ports: Vec::new(),
            topics,
        }
    }

    /// Finds an input port, and checks that it can take the sample.
    pub(crate) fn port(&self, name: &str, sample: &Arc<dyn Sample>) -> Result<Place, RunError> {
        let Some(index) = self.ports.iter().position(|door| door.name == name) else {
            return Err(RunError::Unknown {
                what: "input",
                name: name.to_owned(),
                nearest: suggestion_among(name, self.ports.iter().map(|door| &*door.name)),
            });
        };
        self.ports[index].accepts(sample)?;
        Ok(Place::Port(index))
    }

    /// Finds a topic, and checks that its subscribers can take the sample.
    pub(crate) fn topic(&self, name: &str, sample: &Arc<dyn Sample>) -> Result<Place, RunError> {
        let Some(index) = self.topics.iter().position(|(topic, _)| topic == name) else {
            return Err(RunError::Unknown {
                what: "topic",
                name: name.to_owned(),
                nearest: suggestion_among(name, self.topics.iter().map(|(topic, _)| &**topic)),
            });
        };
        let doors = &self.topics[index].1;
        doors.iter().try_for_each(|door| door.accepts(sample))?;
        Ok(Place::Topic(index))
    }

    /// Gives a sample to its place.
    pub(crate) fn give(
        &mut self,
        place: Place,
        sample: &Arc<dyn Sample>,
        now: Time,
        outside: &mut dyn Outside,
    ) {
        let name = match place {
            Place::Port(port) => &self.ports[port].name,
            Place::Topic(topic) => &self.topics[topic].0,
        };
        outside.emit(
            now,
            &Event::Injected {
                place: name,
                sample: &**sample,
            },
        );
        for door in self.at(place) {
            door.give(sample, now, outside);
        }
    }

    fn at(&mut self, place: Place) -> &mut [Door] {
        match place {
            Place::Port(port) => std::slice::from_mut(&mut self.ports[port]),
            Place::Topic(topic) => self.topics[topic].1.as_mut_slice(),
        }
    }
}

impl Door {
    /// Opens a door. `None` if the policy asks for zeros that the type does not have, which joining has refused.
    pub(crate) fn open(
        unit: &mut Unit,
        index: usize,
        policy: &Policy,
        connection: ConnectionId,
    ) -> Option<Self> {
        let port = unit.body.declaration.inputs.get(index)?;
        let input = unit.body.inputs.get_mut(index)?;
        let (sender, incoming) = (input.inlet())
            .open(connection, &policy.for_outsider(), None)
            .ok()?;
        input.join(incoming);
        Some(Self {
            name: format!("{}.{}", unit.name, port.name),
            component: unit.index,
            trigger: policy.trigger,
            expected: port.schema.to_string(),
            sender,
            dropped: 0,
        })
    }

    fn accepts(&self, sample: &Arc<dyn Sample>) -> Result<(), RunError> {
        self.sender
            .accepts(sample)
            .map_err(|source| RunError::Mismatch {
                place: self.name.clone(),
                expected: self.expected.clone(),
                source: Box::new(source),
            })
    }

    /// Lets in a sample that came to this port alone.
    pub(crate) fn let_in(
        &mut self,
        sample: &Arc<dyn Sample>,
        now: Time,
        outside: &mut dyn Outside,
    ) {
        outside.emit(
            now,
            &Event::Injected {
                place: &self.name,
                sample: &**sample,
            },
        );
        self.give(sample, now, outside);
    }

    fn give(&mut self, sample: &Arc<dyn Sample>, now: Time, outside: &mut dyn Outside) {
        let order = outside.next_order();
        let delivery = self.sender.send_sample(Arc::clone(sample), now, order);
        if self.trigger && matches!(delivery, Ok(Delivery::Stored | Delivery::DroppedOldest)) {
            outside.trigger(self.component);
        }
        if delivery != Ok(Delivery::Stored) {
            self.drop_some(1, delivery.as_ref().err(), now, outside);
        }
    }

    /// Counts samples that did not get in.
    pub(crate) fn drop_some(
        &mut self,
        count: u64,
        reason: Option<&DatumError>,
        now: Time,
        outside: &mut dyn Outside,
    ) {
        self.dropped += count;
        outside.emit(
            now,
            &Event::Dropped {
                component: "",
                port: "outside",
                to: &self.name,
                total: self.dropped,
                reason,
            },
        );
    }
}
