//! Connects port to port and port to topic, and wires reference to service.

use std::sync::Arc;

use asmotion_component::declaration::{
    Declaration, OperationDeclaration, ReferenceDeclaration, ServiceDeclaration,
};
use asmotion_component::{BusHealth, Drive, HEALTH_TOPIC, Wire, suggestion_among};
use asmotion_datum::{DatumError, DatumProblem, Message, Schema};
use asmotion_port::{ConnectionId, OutputLink, Policy};

use super::{ComponentId, System};
use crate::build_error::BuildError;
use crate::component_end::{self, ComponentEnd, EndTable, inputs, outputs, references, services};
use crate::injection::InjectionPort;
use crate::service::{RequiredReference, Wiring};
use crate::stream::{Sink, SinkSender, SinkStream, Source, SourceStream};
use crate::topic::SystemTopic;

impl System {
    /// Connects an output to an input: `connect("TrajectoryFollower.twist", "RoverDriver.twist", Policy::data())`.
    ///
    /// # Errors
    /// An end does not exist or has the wrong direction, the two are connected already, their types differ, or the
    /// policy is impossible for their threads.
    pub fn connect(&mut self, from: &str, to: &str, policy: Policy) -> Result<(), BuildError> {
        let from = self.end(from, outputs)?;
        let to = self.end(to, inputs)?;
        self.connections.check_unconnected(&from, &to)?;
        let connection = self.add_connection(&from, &to, &policy)?;
        self.connections.insert(connection, from, to);
        Ok(())
    }

    /// Runs a component in the thread of another one, right after it (RTT `SlaveActivity`). The slave's own period has
    /// no effect.
    ///
    /// # Errors
    /// [`BuildError::Unknown`] if one of them does not exist, [`BuildError::MasterCycle`] if the slave would cycle
    /// after itself.
    pub fn add_slave(&mut self, slave: &str, master: &str) -> Result<(), BuildError> {
        let [slave_index, master_index] = [self.component(slave)?.0, self.component(master)?.0];
        if self.thread(master_index) == slave_index {
            return Err(BuildError::MasterCycle {
                slave: slave.to_owned(),
                master: master.to_owned(),
            });
        }
        let unit = &mut self.units[slave_index];
        unit.activity.drive = Drive::Slave;
        unit.master = Some(master_index);
        Ok(())
    }

    /// Position of the component in whose thread a component cycles: its master's master, or itself.
    pub(super) fn thread(&self, unit: usize) -> usize {
        let mut unit = unit;
        while let Some(master) = self.units[unit].master {
            unit = master;
        }
        unit
    }

    /// Publishes an output on a topic. An output has one topic; a topic may have several publishers.
    ///
    /// # Errors
    /// [`BuildError::AlreadyConnected`] if the output has a topic, [`BuildError::ReservedTopic`] for the topic of the
    /// health of the bus, or the types of output and a subscriber differ.
    pub fn publish(&mut self, from: &str, topic: &str) -> Result<(), BuildError> {
        let from = self.end(from, outputs)?;
        if topic == HEALTH_TOPIC {
            return Err(BuildError::ReservedTopic {
                from: from.name,
                topic: HEALTH_TOPIC,
            });
        }
        if let Some(taken) = &self.units[from.unit].body.topics[from.index] {
            return Err(BuildError::AlreadyConnected {
                end: from.name,
                to: format!("topic `{taken}`"),
            });
        }
        let index = self.topic_index(topic);
        for (to, policy) in self.topics[index].subscribers.clone() {
            self.connect_topic(&from, &to, &policy)?;
        }
        self.units[from.unit].body.topics[from.index] = Some(topic.to_owned());
        self.topics[index].publishers.push(from);
        Ok(())
    }

    /// Subscribes an input to a topic, with this policy for each of its publishers.
    ///
    /// # Errors
    /// [`BuildError::AlreadyConnected`] if the input reads the topic already, [`BuildError::TypeMismatch`] if it cannot
    /// read what a publisher writes, or the policy is impossible for their threads.
    pub fn subscribe(&mut self, topic: &str, to: &str, policy: Policy) -> Result<(), BuildError> {
        let to = self.end(to, inputs)?;
        let index = self.topic_index(topic);
        let known = &self.topics[index].subscribers;
        if known.iter().any(|(known, _)| *known == to) {
            return Err(BuildError::AlreadyConnected {
                end: to.name,
                to: format!("topic `{topic}`"),
            });
        }
        if topic == HEALTH_TOPIC {
            self.compare_types(BusHealth::schema(), HEALTH_TOPIC, &to)?;
        }
        for from in self.topics[index].publishers.clone() {
            self.connect_topic(&from, &to, &policy)?;
        }
        self.topics[index].subscribers.push((to, policy));
        Ok(())
    }

    /// Sends the samples of an output to a sink too. The sink is called in the component's cycle.
    ///
    /// # Errors
    /// There is no such output.
    pub fn connect_sink(&mut self, from: &str, mut sink: Box<dyn Sink>) -> Result<(), BuildError> {
        let from = self.end(from, outputs)?;
        let unit = &mut self.units[from.unit];
        let link = OutputLink::external(sink.name());
        if let Some(upkeep) = sink.upkeep() {
            self.sinks.push(SinkStream {
                upkeep,
                component: Arc::clone(&unit.name),
                port: unit.body.declaration.outputs[from.index].name.clone(),
                to: sink.name(),
                dropped: Arc::clone(&link.dropped),
            });
        }
        unit.body.outputs[from.index].connect(Box::new(SinkSender(sink)), link);
        Ok(())
    }

    /// Feeds the samples of a source into an input, through a thread of its own in a live system. In simulated time a
    /// source is never read.
    ///
    /// # Errors
    /// There is no such input; [`BuildError::NoZero`] if the policy asks for an initial sample and its type has none.
    pub fn connect_source(
        &mut self,
        source: Box<dyn Source>,
        to: &str,
        policy: &Policy,
    ) -> Result<(), BuildError> {
        let to = self.end(to, inputs)?;
        let unit = &mut self.units[to.unit];
        let port = InjectionPort::open(unit, to.index, policy, self.connections.next_id())
            .ok_or_else(|| BuildError::NoZero {
                to: to.name,
                source: DatumError::new(DatumProblem::Mismatch("expected a record".to_owned())),
            })?;
        self.streams.push(SourceStream { source, port });
        Ok(())
    }

    /// Wires a reference to a service: `wire("ASMCoordinator.planner", "TrajectoryPlanner.planning", wire)`. A
    /// reference has one service, several that receive one-way calls ([`Wire::one_way`]), or several
    /// [alternatives](Wire::alternative).
    ///
    /// # Errors
    /// [`BuildError::AlreadyConnected`] if the reference has a service, [`BuildError::InterfaceMismatch`],
    /// [`BuildError::MissingOperation`] or [`BuildError::TypeMismatch`] if the service does not offer what the
    /// reference calls.
    pub fn wire(&mut self, from: &str, to: &str, wire: Wire) -> Result<(), BuildError> {
        let from = self.end(from, references)?;
        let to = self.end(to, services)?;
        let reference = self.open_reference(&from, &to.name, wire)?;
        let service = &self.units[to.unit].body.services[to.index];
        let wiring = Wiring {
            operations: operation_indices(
                (&reference.declaration, &from),
                (&service.declaration, &to),
            )?,
            queue: Arc::clone(&service.queue),
            to: to.name.clone(),
            provider: Some(to.unit),
            wire,
        };
        let reference = &mut self.units[from.unit].body.references[from.index];
        reference.add(wiring);
        Ok(())
    }

    /// Returns the reference if it can have this service too.
    pub(super) fn open_reference(
        &self,
        from: &ComponentEnd,
        to: &str,
        wire: Wire,
    ) -> Result<&RequiredReference, BuildError> {
        let reference = &self.units[from.unit].body.references[from.index];
        let stands_in_the_way = |wiring: &&Wiring| {
            let are_told = wire.one_way && wiring.wire.one_way;
            wiring.to == to || wiring.wire.alternative == wire.alternative && !are_told
        };
        match reference.wirings.iter().find(stands_in_the_way) {
            None => Ok(reference),
            Some(wiring) => Err(BuildError::AlreadyConnected {
                end: from.name.clone(),
                to: format!("`{}`", wiring.to),
            }),
        }
    }

    /// Position of a topic, which is created if need be.
    fn topic_index(&mut self, name: &str) -> usize {
        if let Some(position) = self.topic_positions.get(name) {
            return *position;
        }
        let position = self.topics.len();
        self.topic_positions.insert(name.to_owned(), position);
        self.topics.push(SystemTopic {
            name: name.to_owned(),
            publishers: Vec::new(),
            subscribers: Vec::new(),
        });
        position
    }

    /// Connects a publisher to a subscriber, unless adapters do so.
    fn connect_topic(
        &mut self,
        from: &ComponentEnd,
        to: &ComponentEnd,
        policy: &Policy,
    ) -> Result<(), BuildError> {
        if self.topics_outside {
            return self.compare(from, to);
        }
        let connection = self.add_connection(from, to, policy)?;
        let (from, to) = (from.clone(), to.clone());
        self.connections.insert_by_topic(connection, from, to);
        Ok(())
    }

    fn compare(&self, from: &ComponentEnd, to: &ComponentEnd) -> Result<(), BuildError> {
        let output = self.units[from.unit].body.outputs[from.index].schema();
        self.compare_types(output, &from.name, to)
    }

    fn compare_types(
        &self,
        written: &Schema,
        from: &str,
        to: &ComponentEnd,
    ) -> Result<(), BuildError> {
        let input = self.units[to.unit].body.inputs[to.index].schema();
        BuildError::compare(written, from, input, &to.name)
    }

    fn add_connection(
        &mut self,
        from: &ComponentEnd,
        to: &ComponentEnd,
        policy: &Policy,
    ) -> Result<ConnectionId, BuildError> {
        self.compare(from, to)?;
        let threads = [from.unit, to.unit].map(|unit| self.thread(unit));
        let input = &mut self.units[to.unit].body.inputs[to.index];
        let connection = self
            .connections
            .open((from, to), threads, policy, &*input.opener())?;
        input.connect(connection.reading_end);
        self.units[from.unit].body.outputs[from.index].connect(connection.sender, connection.link);
        Ok(connection.connection)
    }

    pub(super) fn end(
        &self,
        path: &str,
        table: fn(&Declaration) -> EndTable<'_>,
    ) -> Result<ComponentEnd, BuildError> {
        let (component, _) = component_end::split(path);
        if let Some(ComponentId(unit)) = self.id(component) {
            let declaration = &*self.units[unit].body.declaration;
            return component_end::find_in((unit, declaration), path, table);
        }
        let units = self.units.iter();
        component_end::find(
            units.map(|unit| (&*unit.name, &*unit.body.declaration)),
            path,
            table,
        )
    }

    fn component(&self, name: &str) -> Result<ComponentId, BuildError> {
        self.id(name).ok_or_else(|| BuildError::Unknown {
            kind: "component",
            name: name.to_owned(),
            nearest: suggestion_among(name, self.units.iter().map(|unit| &*unit.name)),
        })
    }
}

/// Position in the service of each operation that a reference calls.
pub(crate) fn operation_indices(
    (reference, from): (&ReferenceDeclaration, &ComponentEnd),
    (service, to): (&ServiceDeclaration, &ComponentEnd),
) -> Result<Vec<usize>, BuildError> {
    if reference.interface != service.interface {
        return Err(BuildError::InterfaceMismatch {
            required: reference.interface.clone(),
            provided: service.interface.clone(),
            from: from.name.clone(),
            to: to.name.clone(),
        });
    }
    let called = reference.operations.iter();
    called
        .map(|called| find_operation(called, &service.operations, from, to))
        .collect()
}

/// Position in the service of one operation that a reference calls.
fn find_operation(
    called: &OperationDeclaration,
    served: &[OperationDeclaration],
    from: &ComponentEnd,
    to: &ComponentEnd,
) -> Result<usize, BuildError> {
    let found = served
        .iter()
        .enumerate()
        .find(|(_, served)| served.name == called.name);
    let Some((index, operation)) = found else {
        return Err(BuildError::MissingOperation {
            from: from.name.clone(),
            operation: called.name.clone(),
            to: to.name.clone(),
        });
    };
    called
        .request
        .compare(&operation.request)
        .and_then(|()| called.response.compare(&operation.response))
        .map_err(|difference| BuildError::TypeMismatch {
            from: from.name.clone(),
            to: to.name.clone(),
            difference: Box::new(difference),
        })?;
    Ok(index)
}
