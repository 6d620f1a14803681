//! What adapters build on: the ends of a system, and how something outside is joined to them.

use std::sync::Arc;

use asmotion_component::Wire;
use asmotion_component::declaration::ServiceDeclaration;
use asmotion_datum::Schema;
use asmotion_port::{AnySender, Notifier, OutputLink, Policy};

use super::System;
use crate::adapter::Adapter;
use crate::build_error::BuildError;
use crate::cause::CycleCause;
use crate::end::{ComponentEnd, outputs, references, services};
use crate::injection::{InjectionPort, InjectionPorts};
use crate::service::{RequestQueue, Wiring};
use crate::topic::SystemTopic;

impl System {
    /// Leaves it to adapters to join publishers and subscribers, also of components of this system. Must come before the
    /// first [`publish`](Self::publish) and [`subscribe`](Self::subscribe).
    pub fn leave_topics_to_adapters(&mut self) {
        self.topics_outside = true;
    }

    /// Whether adapters join publishers and subscribers inside the system too.
    pub fn leaves_topics_to_adapters(&self) -> bool {
        self.topics_outside
    }

    /// Adds an adapter. Adapters deliver in order of addition.
    pub fn add_adapter(&mut self, adapter: Box<dyn Adapter>) {
        self.adapters.push(adapter);
    }

    /// Notified by adapters when something has come or waits to go; wakes the thread that lets them deliver.
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
    /// There is none.
    pub fn output(&self, path: &str) -> Result<ComponentEnd, BuildError> {
        self.end(path, outputs)
    }

    /// The service at a path, `component.service`.
    ///
    /// # Errors
    /// There is none.
    pub fn service(&self, path: &str) -> Result<ComponentEnd, BuildError> {
        self.end(path, services)
    }

    /// The reference at a path, `component.reference`.
    ///
    /// # Errors
    /// There is none.
    pub fn reference(&self, path: &str) -> Result<ComponentEnd, BuildError> {
        self.end(path, references)
    }

    /// The name of an end's component.
    pub fn component_of(&self, end: &ComponentEnd) -> Arc<str> {
        Arc::clone(&self.units[end.unit].name)
    }

    /// What the cycles of an end's component follow from.
    pub fn cause_of(&self, end: &ComponentEnd) -> Arc<CycleCause> {
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

    /// Sends the samples of an output to something outside as well, whose name events show.
    pub fn join_output(&mut self, output: &ComponentEnd, sender: Box<dyn AnySender>, to: String) {
        let unit = &mut self.units[output.unit];
        unit.body.outputs[output.index].join(sender, OutputLink::to_outside(to));
    }

    /// Opens a connection from outside into an input. `None` if the policy asks for zeros that the type does not have.
    pub fn injection_port(
        &mut self,
        input: &ComponentEnd,
        policy: &Policy,
    ) -> Option<InjectionPort> {
        let number = self.connections.number();
        InjectionPort::open(&mut self.units[input.unit], input.index, policy, number)
    }

    /// Opens connections from outside into the subscribers of topics.
    pub fn injection_topics(&mut self, topics: &[SystemTopic]) -> InjectionPorts {
        InjectionPorts::of_topics(&mut self.units, topics, &mut self.connections)
    }

    /// What a service declares, and the queue that its requests go into.
    pub fn service_at(&self, service: &ComponentEnd) -> (&ServiceDeclaration, Arc<RequestQueue>) {
        let service = &self.units[service.unit].body.services[service.index];
        (&service.declaration, Arc::clone(&service.queue))
    }

    /// Wires a reference to a remote service of this name: its requests go into the queue, which an adapter empties.
    /// Returns the operations that the reference calls; their positions are those of the requests' operations.
    ///
    /// # Errors
    /// The reference has a service already.
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
        reference.wirings.push(wiring);
        Ok(operations)
    }
}
