//! Doors: ways into input ports for those outside of the system, and the topics as seen from there.

use std::sync::Arc;

use datum::Sample;

use crate::outside::Outside;
use crate::port::AnySender;
use crate::property::suggestion_among;
use crate::run::RunError;
use crate::system::Topic;
use crate::unit::Unit;
use crate::{Event, Policy, Time};

/// How many samples from outside may wait for a component's next cycle.
const WAITING: usize = 64;

/// A way into one input port.
pub(crate) struct Door {
    /// `Component.port`.
    name: String,
    component: usize,
    expected: String,
    sender: Box<dyn AnySender>,
}

/// All doors of a system.
pub(crate) struct Doors {
    doors: Vec<Door>,
    /// Topics by name, with the doors of their subscribers.
    topics: Vec<(String, Vec<usize>)>,
}

/// Where a sample from outside goes.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Place {
    Door(usize),
    Topic(usize),
}

impl Doors {
    pub(crate) fn new(units: &mut [Unit], topics: &[Topic]) -> Self {
        let mut doors = Vec::new();
        for unit in units {
            let names = unit.body.declaration.inputs.iter();
            for (input, port) in unit.body.inputs.iter_mut().zip(names) {
                // Zeros are not asked for, so opening cannot fail.
                let Ok(sender) = input.open(&Policy::buffer(WAITING)) else {
                    continue;
                };
                doors.push(Door {
                    name: format!("{}.{}", unit.name, port.name),
                    component: unit.index,
                    expected: port.schema.to_string(),
                    sender,
                });
            }
        }
        let door_of = |name: &String| doors.iter().position(|door| door.name == *name);
        let topics = topics
            .iter()
            .map(|topic| {
                let ends = topic.subscribers.iter();
                let names = ends.map(|(end, _)| end.to_string());
                (topic.name.clone(), names.filter_map(|name| door_of(&name)).collect())
            })
            .collect();
        Self { doors, topics }
    }

    /// Finds an input port, and checks that it can take the sample.
    pub(crate) fn port(&self, name: &str, sample: &Arc<dyn Sample>) -> Result<Place, RunError> {
        let Some(index) = self.doors.iter().position(|door| door.name == name) else {
            return Err(RunError::Unknown {
                what: "input",
                name: name.to_owned(),
                nearest: suggestion_among(name, self.doors.iter().map(|door| &*door.name)),
            });
        };
        self.doors[index].accepts(sample)?;
        Ok(Place::Door(index))
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
        for door in &self.topics[index].1 {
            self.doors[*door].accepts(sample)?;
        }
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
            Place::Door(door) => &self.doors[door].name,
            Place::Topic(topic) => &self.topics[topic].0,
        };
        outside.emit(
            now,
            &Event::Injected {
                place: name,
                sample: &**sample,
            },
        );
        match place {
            Place::Door(door) => self.doors[door].give(sample, now, outside),
            Place::Topic(topic) => {
                for door in &self.topics[topic].1 {
                    self.doors[*door].give(sample, now, outside);
                }
            }
        }
    }
}

impl Door {
    fn accepts(&self, sample: &Arc<dyn Sample>) -> Result<(), RunError> {
        self.sender
            .accepts(sample)
            .map_err(|source| RunError::Mismatch {
                place: self.name.clone(),
                expected: self.expected.clone(),
                source,
            })
    }

    fn give(&mut self, sample: &Arc<dyn Sample>, now: Time, outside: &mut dyn Outside) {
        let order = outside.next_order();
        let delivery = self.sender.send_sample(Arc::clone(sample), now, order);
        if delivery == Ok(crate::connection::Delivery::Stored) {
            return outside.trigger(self.component);
        }
        outside.emit(
            now,
            &Event::Dropped {
                component: "outside",
                port: "",
                to: &self.name,
                total: 1,
            },
        );
    }
}
