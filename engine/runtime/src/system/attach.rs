//! The interface for adapters: finds the ends of a system and connects them to the outside.

use std::sync::Arc;

use asmotion_component::Wire;
use asmotion_component::declaration::{ReferenceDeclaration, ServiceDeclaration};
use asmotion_datum::Schema;
use asmotion_port::{AnySender, ConnectionId, Notifier, OutputLink, Policy};

use super::ComponentId;
use super::System;
use crate::adapter::Adapter;
use crate::build_error::BuildError;
use crate::cause::CycleCause;
use crate::component_end::{ComponentEnd, outputs, references, services};
use crate::connections::HeldEnd;
use crate::injection::{InjectionPort, InjectionPorts};
use crate::opened_end::OpenedEnd;
use crate::service::{RequestQueue, Wiring};
use crate::topic::SystemTopic;

impl System {
    /// Lets adapters connect all publishers and subscribers, including those within this system. Call this before the
    /// first [`publish`](Self::publish) and [`subscribe`](Self::subscribe).
    pub fn leave_topics_to_adapters(&mut self) {
        self.topics_outside = true;
    }

    /// Returns whether adapters connect publishers and subscribers within the system too.
    pub fn leaves_topics_to_adapters(&self) -> bool {
        self.topics_outside
    }

    /// Adds an adapter. Adapters are called in order of addition.
    pub fn add_adapter(&mut self, adapter: Box<dyn Adapter>) {
        self.adapters.push(adapter);
    }

    /// Wakes the thread that calls the adapters. An adapter notifies it when messages have arrived or wait to be sent.
    pub fn notifier(&self) -> &Arc<Notifier> {
        &self.notifier
    }

    /// The topics declared so far, in order of declaration.
    pub fn topics(&self) -> &[SystemTopic] {
        &self.topics
    }

    /// The output port at a path, `component.port`.
    ///
    /// # Errors
    /// [`BuildError::Unknown`] or [`BuildError::Direction`] if there is no such output.
    pub fn output(&self, path: &str) -> Result<ComponentEnd, BuildError> {
        self.end(path, outputs)
    }

    /// The service at a path, `component.service`.
    ///
    /// # Errors
    /// [`BuildError::Unknown`] or [`BuildError::Direction`] if there is no such service.
    pub fn service(&self, path: &str) -> Result<ComponentEnd, BuildError> {
        self.end(path, services)
    }

    /// The reference at a path, `component.reference`.
    ///
    /// # Errors
    /// [`BuildError::Unknown`] or [`BuildError::Direction`] if there is no such reference.
    pub fn reference(&self, path: &str) -> Result<ComponentEnd, BuildError> {
        self.end(path, references)
    }

    /// Sets the name of a component outside the system: on buses, in the names of its queues there, and as the source of its
    /// messages (default: its name in the system).
    pub fn set_external_name(&mut self, component: ComponentId, name: &str) {
        self.external_names.insert(component.0, name.into());
    }

    /// The name of an end's component outside the system.
    pub fn external_name(&self, end: &ComponentEnd) -> Arc<str> {
        let name = self.external_names.get(&end.unit);
        Arc::clone(name.unwrap_or(&self.units[end.unit].name))
    }

    /// The cause of the cycles of an end's component.
    pub fn cycle_cause(&self, end: &ComponentEnd) -> Arc<CycleCause> {
        Arc::clone(&self.units[end.unit].body.cause)
    }

    /// The message type of an output.
    pub fn output_schema(&self, output: &ComponentEnd) -> &Schema {
        self.units[output.unit].body.outputs[output.index].schema()
    }

    /// The message type of an input.
    pub fn input_schema(&self, input: &ComponentEnd) -> &Schema {
        self.units[input.unit].body.inputs[input.index].schema()
    }

    /// Sends the samples of an output to `sender` as well; events show it under the name `to`.
    pub fn connect_output(
        &mut self,
        output: &ComponentEnd,
        sender: Box<dyn AnySender>,
        to: String,
    ) {
        let unit = &mut self.units[output.unit];
        unit.body.outputs[output.index].connect(sender, OutputLink::external(to));
    }

    /// Keeps what an adapter has opened for an end, with the name of the end outside and the connection into an input. It is
    /// dropped when the end is [parted](crate::Change::Part) or its component is removed.
    pub fn hold_end(
        &mut self,
        end: &ComponentEnd,
        outside: String,
        connection: Option<ConnectionId>,
        opened: Box<dyn OpenedEnd>,
    ) {
        let end = end.clone();
        self.connections.outer_ends.push(HeldEnd {
            end,
            outside,
            connection,
            opened,
        });
    }

    /// Opens a connection from outside into an input. Returns `None` if the policy asks for zeros that the type does
    /// not have.
    pub fn injection_port(
        &mut self,
        input: &ComponentEnd,
        policy: &Policy,
    ) -> Option<InjectionPort> {
        let number = self.connections.next_id();
        InjectionPort::open(&mut self.units[input.unit], input.index, policy, number)
    }

    /// Opens connections from outside into the subscribers of topics.
    pub fn injection_topics(&mut self, topics: &[SystemTopic]) -> InjectionPorts {
        InjectionPorts::of_topics(&mut self.units, topics, &mut self.connections)
    }

    /// The declaration of a service, and its request queue.
    pub fn provided_service(
        &self,
        service: &ComponentEnd,
    ) -> (&ServiceDeclaration, Arc<RequestQueue>) {
        let service = &self.units[service.unit].body.services[service.index];
        (&service.declaration, Arc::clone(&service.queue))
    }

    /// The declaration of a reference.
    pub fn required_service(&self, reference: &ComponentEnd) -> &ReferenceDeclaration {
        &self.units[reference.unit].body.references[reference.index].declaration
    }

    /// Wires a reference to a remote service of this name: requests go into the queue, which an adapter empties.
    /// Returns the operations that the reference calls; [`ServiceRequest::operation`](crate::ServiceRequest) is a
    /// position in this list.
    ///
    /// # Errors
    /// [`BuildError::AlreadyConnected`] if the reference has a service already.
    pub fn wire_remote(
        &mut self,
        from: &ComponentEnd,
        service: &str,
        wire: Wire,
        queue: Arc<RequestQueue>,
    ) -> Result<Vec<String>, BuildError> {
        let reference = self.open_reference(from, service, wire)?;
        let operations = reference.declaration.operations.iter();
        let operations: Vec<String> = operations.map(|called| called.name.clone()).collect();
        let wiring = Wiring {
            queue,
            to: service.to_owned(),
            provider: None,
            operations: (0..operations.len()).collect(),
            wire,
        };
        let reference = &mut self.units[from.unit].body.references[from.index];
        reference.add(wiring);
        Ok(operations)
    }
}
