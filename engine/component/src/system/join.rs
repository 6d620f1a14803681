//! Joining: port to port, port to topic, reference to service.

use std::sync::Arc;
use std::sync::atomic::AtomicU64;

use bus::Sending;
use datum::{DatumError, Message, Problem, Schema};

use super::{BuildError, System, Topic};
use crate::body::Body;
use crate::declaration::{OperationDeclaration, PortDeclaration};
use crate::door::Door;
use crate::port::Link;
use crate::property::suggestion_among;
use crate::service::{Reference, Wire, Wiring};
use crate::stream::{Incoming, Outgoing, Sink, Source};
use crate::{BusHealth, HEALTH_TOPIC, Policy};

/// One end of a connection.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct End {
    /// `component.port`.
    pub name: String,
    /// The component's place in the system.
    pub unit: usize,
    /// The port's, service's or reference's place in the component.
    pub index: usize,
}

/// A table of a component's named things.
pub(super) struct Table<'a> {
    what: &'static str,
    names: Vec<&'a str>,
}

fn inputs(body: &Body) -> Table<'_> {
    ports("input", &body.declaration.inputs)
}

pub(super) fn outputs(body: &Body) -> Table<'_> {
    ports("output", &body.declaration.outputs)
}

fn ports<'a>(what: &'static str, ports: &'a [PortDeclaration]) -> Table<'a> {
    Table {
        what,
        names: ports.iter().map(|port| &*port.name).collect(),
    }
}

pub(super) fn services(body: &Body) -> Table<'_> {
    let services = &body.declaration.services;
    Table {
        what: "service",
        names: services.iter().map(|service| &*service.name).collect(),
    }
}

pub(super) fn references(body: &Body) -> Table<'_> {
    let references = &body.declaration.references;
    Table {
        what: "reference",
        names: references
            .iter()
            .map(|reference| &*reference.name)
            .collect(),
    }
}

impl System {
    /// Connects an output to an input: `connect("TrajectoryFollower.twist", "RoverDriver.twist", Policy::data())`.
    pub fn connect(&mut self, from: &str, to: &str, policy: Policy) -> Result<(), BuildError> {
        let from = self.end(from, outputs)?;
        let to = self.end(to, inputs)?;
        let connection = (from, to);
        if self.connections.contains(&connection) {
            return Err(BuildError::Joined {
                end: connection.0.name,
                to: format!("`{}`", connection.1.name),
            });
        }
        self.join(&connection.0, &connection.1, &policy)?;
        self.connections.push(connection);
        Ok(())
    }

    /// Lets an output publish to a topic. An output has one topic; a topic may have several publishers.
    pub fn publish(&mut self, from: &str, topic: &str) -> Result<(), BuildError> {
        let from = self.end(from, outputs)?;
        if topic == HEALTH_TOPIC {
            return Err(BuildError::OwnTopic {
                from: from.name,
                topic: HEALTH_TOPIC,
            });
        }
        if let Some(taken) = &self.units[from.unit].body.topics[from.index] {
            return Err(BuildError::Joined {
                end: from.name,
                to: format!("topic `{taken}`"),
            });
        }
        let index = self.topic(topic);
        for (to, policy) in self.topics[index].subscribers.clone() {
            self.join_topic(&from, &to, &policy)?;
        }
        self.units[from.unit].body.topics[from.index] = Some(topic.to_owned());
        self.topics[index].publishers.push(from);
        Ok(())
    }

    /// Lets an input read a topic, from each of its publishers with this policy.
    pub fn subscribe(&mut self, topic: &str, to: &str, policy: Policy) -> Result<(), BuildError> {
        let to = self.end(to, inputs)?;
        let index = self.topic(topic);
        let known = &self.topics[index].subscribers;
        if known.iter().any(|(known, _)| *known == to) {
            return Err(BuildError::Joined {
                end: to.name,
                to: format!("topic `{topic}`"),
            });
        }
        if topic == HEALTH_TOPIC {
            self.compare_types(BusHealth::schema(), HEALTH_TOPIC, &to)?;
        }
        for from in self.topics[index].publishers.clone() {
            self.join_topic(&from, &to, &policy)?;
        }
        self.topics[index].subscribers.push((to, policy));
        Ok(())
    }

    /// Lets the samples of an output go to a sink, too; live, in its component's cycle.
    pub fn stream_out(&mut self, from: &str, sink: Box<dyn Sink>) -> Result<(), BuildError> {
        let from = self.end(from, outputs)?;
        let link = Link::to_bus(sink.name());
        self.units[from.unit].body.outputs[from.index].join(Box::new(Outgoing(sink)), link);
        Ok(())
    }

    /// Lets the samples of a source into an input; live, by a thread of its own. In simulated time nothing comes.
    pub fn stream_in(
        &mut self,
        source: Box<dyn Source>,
        to: &str,
        policy: &Policy,
    ) -> Result<(), BuildError> {
        let to = self.end(to, inputs)?;
        let unit = &mut self.units[to.unit];
        let door = Door::open(unit, to.index, policy).ok_or_else(|| BuildError::NoZero {
            to: to.name,
            source: DatumError::new(Problem::Mismatch("it is no record".to_owned())),
        })?;
        self.streams.push(Incoming { source, door });
        Ok(())
    }

    /// Says how a topic is sent over a bus: how sure its messages are to arrive, and what becomes of them while the bus
    /// is away. Inside the system nothing changes.
    pub fn sending(&mut self, topic: &str, sending: Sending) {
        let index = self.topic(topic);
        self.topics[index].sending = sending;
    }

    /// Wires a reference to a service: `wire("ASMCoordinator.planner", "TrajectoryPlanner.planning", wire)`. A reference
    /// has one service, or several that are told and do not answer ([`Wire::one_way`]).
    pub fn wire(&mut self, from: &str, to: &str, wire: Wire) -> Result<(), BuildError> {
        let from = self.end(from, references)?;
        let to = self.end(to, services)?;
        let reference = self.open_reference(&from, &to.name, wire)?;
        let service = &self.units[to.unit].body.services[to.index];
        if reference.declaration.interface != service.declaration.interface {
            return Err(BuildError::Interfaces {
                required: reference.declaration.interface.clone(),
                provided: service.declaration.interface.clone(),
                from: from.name,
                to: to.name,
            });
        }
        let mut operations = Vec::new();
        for called in &reference.declaration.operations {
            let served = &service.declaration.operations;
            operations.push(find_operation(called, served, &from, &to)?);
        }
        let wiring = Wiring {
            inbox: Arc::clone(&service.inbox),
            to: to.name.clone(),
            provider: Some(to.unit),
            operations,
            wire,
        };
        let reference = &mut self.units[from.unit].body.references[from.index];
        reference.wirings.push(wiring);
        Ok(())
    }

    /// A reference that may have this service, too.
    pub(super) fn open_reference(
        &self,
        from: &End,
        to: &str,
        wire: Wire,
    ) -> Result<&Reference, BuildError> {
        let reference = &self.units[from.unit].body.references[from.index];
        let stands_in_the_way =
            |wiring: &&Wiring| wiring.to == to || !(wire.one_way && wiring.wire.one_way);
        match reference.wirings.iter().find(stands_in_the_way) {
            None => Ok(reference),
            Some(wiring) => Err(BuildError::Joined {
                end: from.name.clone(),
                to: format!("`{}`", wiring.to),
            }),
        }
    }

    /// The place of a topic, made if need be.
    fn topic(&mut self, name: &str) -> usize {
        let found = self.topics.iter().position(|topic| topic.name == name);
        found.unwrap_or_else(|| {
            self.topics.push(Topic {
                name: name.to_owned(),
                publishers: Vec::new(),
                subscribers: Vec::new(),
                sending: Sending::default(),
            });
            self.topics.len() - 1
        })
    }

    /// Joins a publisher to a subscriber, unless the bus does.
    fn join_topic(&mut self, from: &End, to: &End, policy: &Policy) -> Result<(), BuildError> {
        match self.abroad.topics {
            true => self.compare(from, to),
            false => self.join(from, to, policy),
        }
    }

    fn compare(&self, from: &End, to: &End) -> Result<(), BuildError> {
        let output = self.units[from.unit].body.outputs[from.index].schema();
        self.compare_types(output, &from.name, to)
    }

    fn compare_types(&self, written: &Schema, from: &str, to: &End) -> Result<(), BuildError> {
        let input = self.units[to.unit].body.inputs[to.index].schema();
        written
            .compare(input)
            .map_err(|difference| BuildError::Types {
                from: from.to_owned(),
                to: to.name.clone(),
                difference: Box::new(difference),
            })
    }

    fn join(&mut self, from: &End, to: &End, policy: &Policy) -> Result<(), BuildError> {
        self.compare(from, to)?;
        let input = &mut self.units[to.unit].body.inputs[to.index];
        let sender = input.open(policy).map_err(|source| BuildError::NoZero {
            to: to.name.clone(),
            source,
        })?;
        let link = Link {
            reader: to.unit,
            to: to.name.clone(),
            trigger: policy.trigger,
            mandatory: policy.mandatory,
            dropped: Arc::new(AtomicU64::new(0)),
        };
        self.units[from.unit].body.outputs[from.index].join(sender, link);
        Ok(())
    }

    /// Finds `component.port`. Components may have dots in their names, ports have none.
    pub(super) fn end(&self, path: &str, table: fn(&Body) -> Table<'_>) -> Result<End, BuildError> {
        let (component, port) = path.rsplit_once('.').unwrap_or((path, ""));
        let Some(id) = self.id(component) else {
            let names = self.units.iter().map(|unit| &*unit.name);
            return Err(BuildError::Unknown {
                what: "component",
                name: component.to_owned(),
                nearest: suggestion_among(component, names),
            });
        };
        let table = table(&self.units[id.0].body);
        let Some(index) = table.names.iter().position(|name| *name == port) else {
            let nearest = suggestion_among(port, table.names.iter().copied());
            return Err(BuildError::Unknown {
                what: table.what,
                name: path.to_owned(),
                nearest: nearest.map(|port| format!("{component}.{port}")),
            });
        };
        Ok(End {
            name: path.to_owned(),
            unit: id.0,
            index,
        })
    }
}

/// The service's position of an operation that a reference calls.
fn find_operation(
    called: &OperationDeclaration,
    served: &[OperationDeclaration],
    from: &End,
    to: &End,
) -> Result<usize, BuildError> {
    let found = (served.iter().enumerate()).find(|(_, served)| served.name == called.name);
    let Some((index, operation)) = found else {
        return Err(BuildError::Operation {
            from: from.name.clone(),
            operation: called.name.clone(),
            to: to.name.clone(),
        });
    };
    called
        .request
        .compare(&operation.request)
        .and_then(|()| called.response.compare(&operation.response))
        .map_err(|difference| BuildError::Types {
            from: from.name.clone(),
            to: to.name.clone(),
            difference: Box::new(difference),
        })?;
    Ok(index)
}
