//! The interface on which a component's constructor makes its declarations and receives handles.

use std::collections::BTreeSet;
use std::sync::Arc;
use std::sync::atomic::{AtomicU32, AtomicU64, Ordering};

use asmotion_datum::{Datum, Message, Sample, Schema};
use asmotion_port::{AnyInput, AnyOutput, InputPort, OutputPort};

use crate::declaration::{
    Declaration, DeclarationError, OperationDeclaration, PortDeclaration, ReferenceDeclaration,
    ServiceDeclaration,
};
use crate::handle::{In, Out, Property, Provided, Required};
use crate::operation::{
    Dynamic, Handler, Operation, OperationSlot, ServiceFault, read_checked, unreadable,
};
use crate::property::{self, AnyProperty, PropertyValue};

/// Collects the declarations of a component. Construction only declares; it performs no I/O.
pub struct Interface {
    /// Number of this interface, stored in its handles to detect foreign ones.
    owner: u32,
    declaration: Declaration,
    problems: Vec<DeclarationError>,
    inputs: Vec<Box<dyn AnyInput>>,
    outputs: Vec<Box<dyn AnyOutput>>,
    properties: Vec<Box<dyn AnyProperty>>,
    /// Number of property changes. Incremented by each property's slot, compared by `PropertySet`.
    revision: Arc<AtomicU64>,
    /// The operation that each `Provided` handle refers to.
    provided: Vec<OperationSlot>,
    /// For each service and operation, the handler that runs in the caller's thread, if there is one.
    handlers: Vec<Vec<Option<Handler>>>,
    /// The operation that each `Required` handle refers to.
    required: Vec<OperationSlot>,
    /// Positions of the ports of a running component that its successor has not declared yet.
    inherited_inputs: BTreeSet<usize>,
    inherited_outputs: BTreeSet<usize>,
    /// The operations called by a running component that its successor has not declared yet.
    inherited_operations: Vec<OperationSlot>,
}

/// The contents of an [`Interface`] for a runtime: the tables that the component's handles index.
pub struct InterfaceParts {
    /// Number of the interface, stored in its handles.
    pub owner: u32,
    /// The declarations as data.
    pub declaration: Declaration,
    /// Input ports, in order of declaration.
    pub inputs: Vec<Box<dyn AnyInput>>,
    /// Output ports, in order of declaration.
    pub outputs: Vec<Box<dyn AnyOutput>>,
    /// Properties, in order of declaration.
    pub properties: Vec<Box<dyn AnyProperty>>,
    /// The operation that each `Provided` handle refers to.
    pub provided: Vec<OperationSlot>,
    /// For each service and operation, the handler that runs in the caller's thread, if there is one.
    pub handlers: Vec<Vec<Option<Handler>>>,
    /// The operation that each `Required` handle refers to.
    pub required: Vec<OperationSlot>,
}

impl Interface {
    /// Creates an interface without declarations.
    pub fn new() -> Self {
        static LAST: AtomicU32 = AtomicU32::new(0);
        Self {
            owner: LAST.fetch_add(1, Ordering::Relaxed),
            declaration: Declaration::default(),
            problems: Vec::new(),
            inputs: Vec::new(),
            outputs: Vec::new(),
            properties: Vec::new(),
            revision: Arc::default(),
            provided: Vec::new(),
            handlers: Vec::new(),
            required: Vec::new(),
            inherited_inputs: BTreeSet::new(),
            inherited_outputs: BTreeSet::new(),
            inherited_operations: Vec::new(),
        }
    }

    /// Creates an interface for the successor of a running component. A port that both declare keeps its position, and new ports
    /// follow. A port that the successor does not declare stays, without a use. The same holds for references and the operations
    /// called through them.
    pub fn following(running: &Declaration) -> Self {
        let mut interface = Self::new();
        for port in &running.inputs {
            let unused = InputPort::<Datum>::new(port.schema.clone());
            interface.inputs.push(Box::new(unused));
        }
        for port in &running.outputs {
            let unused = OutputPort::<Datum>::new(port.schema.clone());
            interface.outputs.push(Box::new(unused));
        }
        interface.inherited_inputs = (0..running.inputs.len()).collect();
        interface.inherited_outputs = (0..running.outputs.len()).collect();
        interface.declaration.inputs.clone_from(&running.inputs);
        interface.declaration.outputs.clone_from(&running.outputs);
        let references = running.references.iter().enumerate();
        let operations = references.flat_map(|(port, reference)| {
            let operations = 0..reference.operations.len();
            operations.map(move |operation| OperationSlot { port, operation })
        });
        interface.inherited_operations = operations.collect();
        let references = &mut interface.declaration.references;
        references.clone_from(&running.references);
        interface
    }

    /// All declarations, for the runtime that takes over the component. Most components have few ports, so each list has memory for
    /// no more than it holds.
    pub fn into_parts(mut self) -> InterfaceParts {
        self.declaration.shrink();
        self.inputs.shrink_to_fit();
        self.outputs.shrink_to_fit();
        self.properties.shrink_to_fit();
        InterfaceParts {
            owner: self.owner,
            declaration: self.declaration,
            inputs: self.inputs,
            outputs: self.outputs,
            properties: self.properties,
            provided: self.provided,
            handlers: self.handlers,
            required: self.required,
        }
    }

    /// The declarations made so far.
    pub fn declaration(&self) -> &Declaration {
        &self.declaration
    }

    /// Contradictions between the declarations made so far.
    pub fn problems(&self) -> &[DeclarationError] {
        &self.problems
    }

    /// Declares an input port.
    pub fn input<T: Message>(&mut self, name: &str, doc: &str) -> In<T> {
        self.add_input(name, T::schema().clone(), doc)
    }

    /// Declares an input port whose message type is known only at run time.
    pub fn input_of(&mut self, name: &str, schema: Schema, doc: &str) -> In<Datum> {
        self.add_input(name, schema, doc)
    }

    /// Marks an input whose samples are commands: those that arrive while the component does not run are discarded when it
    /// starts, counted as lost and reported, so that it never carries out an old command. Samples of a connection with `init`
    /// are kept; so are those of all other inputs, such as a map that is published once.
    ///
    /// ```
    /// use asmotion_component::{In, Interface};
    ///
    /// asmotion_datum::message! {
    ///     /// A position of a joint.
    ///     pub struct Target = "example/Target" {
    ///         /// rad
    ///         pub angle: f64,
    ///     }
    /// }
    ///
    /// let mut interface = Interface::new();
    /// let target: In<Target> = interface.input("target", "where to turn");
    /// interface.command(target);
    /// assert!(interface.declaration().inputs[0].command);
    /// ```
    pub fn command<T: Message>(&mut self, input: In<T>) -> In<T> {
        let index = input.position(self.owner);
        if let Some(declared) = self.declaration.inputs.get_mut(index) {
            declared.command = true;
        }
        input
    }

    /// Marks an input that may remain without a connection: `check` reports others.
    pub fn optional_input<T: Message>(&mut self, input: In<T>) -> In<T> {
        let index = input.position(self.owner);
        if let Some(declared) = self.declaration.inputs.get_mut(index) {
            declared.optional = true;
        }
        input
    }

    /// Declares an output port.
    pub fn output<T: Message>(&mut self, name: &str, doc: &str) -> Out<T> {
        self.add_output(name, T::schema().clone(), doc)
    }

    /// Declares an output port whose message type is known only at run time.
    pub fn output_of(&mut self, name: &str, schema: Schema, doc: &str) -> Out<Datum> {
        self.add_output(name, schema, doc)
    }

    /// Sets the safe sample of an output: the engine writes it after the component's last cycle, whether the component
    /// stops, fails, or a signal ends its process, so that no actuator keeps the last command. A composite can override it
    /// (`lifecycle.safe`).
    ///
    /// ```
    /// use asmotion_component::{Interface, Out};
    ///
    /// asmotion_datum::message! {
    ///     /// A command to a motor.
    ///     pub struct Velocity = "example/Velocity" {
    ///         /// m/s
    ///         pub forward: f64,
    ///     }
    /// }
    ///
    /// let mut interface = Interface::new();
    /// let velocity: Out<Velocity> = interface.output("velocity", "to the motor");
    /// interface.safe(velocity, Velocity { forward: 0.0 });
    /// assert!(interface.declaration().outputs[0].safe.is_some());
    /// ```
    pub fn safe<T: Message>(&mut self, output: Out<T>, sample: T) -> Out<T> {
        let index = output.position(self.owner);
        let sample = sample.to_datum();
        if let (Some(port), Some(declared)) = (
            self.outputs.get_mut(index),
            self.declaration.outputs.get_mut(index),
        ) {
            match sample.and_then(|sample| port.set_safe(&sample).map(|()| sample)) {
                Ok(sample) => declared.safe = Some(sample),
                Err(error) => self.problems.push(DeclarationError::InvalidDefault {
                    name: declared.name.clone(),
                    reason: error.to_string(),
                }),
            }
        }
        output
    }

    /// Declares an operation that the component provides as part of a service. A service may have several operations.
    pub fn serve<O: Operation>(&mut self, service: &str, doc: &str) -> Provided<O> {
        self.add_provided(
            service,
            O::INTERFACE,
            OperationDeclaration::of::<O>(),
            None,
            doc,
        )
    }

    /// Marks an operation as answered while the component is stopped too, by
    /// [`Component::serve`](crate::Component::serve). Calls of other operations of a stopped component end at once as
    /// [`CallError::Stopped`](crate::CallError::Stopped), as RTT's `OwnThread` operations need a running engine.
    pub fn while_stopped<O: Operation>(&mut self, provided: Provided<O>) -> Provided<O> {
        if let Some(slot) = self.provided.get(provided.position(self.owner))
            && let Some(service) = self.declaration.services.get_mut(slot.port)
            && let Some(operation) = service.operations.get_mut(slot.operation)
        {
            operation.while_stopped = true;
        }
        provided
    }

    /// Declares an operation whose handler runs at once in the caller's thread, concurrently with the component's
    /// cycles and in every state of the component (RTT `ClientThread`).
    pub fn serve_in_caller<O: Operation>(
        &mut self,
        service: &str,
        doc: &str,
        handler: impl Fn(O::Request) -> Result<O::Response, ServiceFault> + Send + Sync + 'static,
    ) {
        let handler = move |argument: Arc<dyn Sample>| {
            let argument = read_checked(argument);
            let argument = argument.map_err(|error| unreadable("BAD_ARGUMENT", &error))?;
            handler(argument).map(|response| Arc::new(response) as Arc<dyn Sample>)
        };
        let handler: Handler = Arc::new(handler);
        let of: Provided<O> = self.add_provided(
            service,
            O::INTERFACE,
            OperationDeclaration::of::<O>(),
            Some(handler),
            doc,
        );
        // the handle is of no further use: no request reaches the component
        self.while_stopped(of);
    }

    /// Declares a provided operation whose types are known only at run time.
    pub fn serve_of(
        &mut self,
        service: &str,
        interface: &str,
        operation: &str,
        doc: &str,
    ) -> Provided<Dynamic> {
        self.add_provided(
            service,
            interface,
            OperationDeclaration::opaque(operation),
            None,
            doc,
        )
    }

    /// Declares a provided operation that passes [`Datum`] values of types known at run time.
    pub fn serve_declared(
        &mut self,
        service: &str,
        interface: &str,
        operation: OperationDeclaration,
        doc: &str,
    ) -> Provided<Dynamic> {
        self.add_provided(service, interface, operation, None, doc)
    }

    /// Declares an operation that the component calls through a reference. A reference may have several operations.
    pub fn require<O: Operation>(&mut self, reference: &str, doc: &str) -> Required<O> {
        self.add_required(
            reference,
            O::INTERFACE,
            OperationDeclaration::of::<O>(),
            doc,
        )
    }

    /// Declares a called operation whose types are known only at run time.
    pub fn require_of(
        &mut self,
        reference: &str,
        interface: &str,
        operation: &str,
        doc: &str,
    ) -> Required<Dynamic> {
        self.add_required(
            reference,
            interface,
            OperationDeclaration::opaque(operation),
            doc,
        )
    }

    /// Declares a called operation that passes [`Datum`] values of types known at run time.
    pub fn require_declared(
        &mut self,
        reference: &str,
        interface: &str,
        operation: OperationDeclaration,
        doc: &str,
    ) -> Required<Dynamic> {
        self.add_required(reference, interface, operation, doc)
    }

    /// Marks a reference as optional: the component works without a service too.
    pub fn optional<O: Operation>(&mut self, required: Required<O>) -> Required<O> {
        let slot = self.required.get(required.position(self.owner));
        if let Some(slot) = slot
            && let Some(reference) = self.declaration.references.get_mut(slot.port)
        {
            reference.optional = true;
        }
        required
    }

    /// Sets the allowed values of a declared property, for a component whose choices are known when it is constructed. A
    /// default that is not among them is a problem of the declaration; a property that is not declared is ignored.
    pub fn set_choices(
        &mut self,
        property: &str,
        choices: impl IntoIterator<Item = impl Into<Datum>>,
    ) {
        let declared = self.declaration.properties.iter_mut();
        let slots = self.properties.iter_mut();
        let pair = declared.zip(slots).find(|(it, _)| it.name == property);
        let Some((declared, slot)) = pair else {
            return;
        };
        declared.choices = choices.into_iter().map(Into::into).collect();
        slot.set_choices(&declared.choices);
        if let Err(problem) = slot.check(&declared.default) {
            self.problems.push(DeclarationError::InvalidDefault {
                name: property.to_owned(),
                reason: problem.to_string(),
            });
        }
    }

    /// The counter of property changes.
    pub(crate) fn revision(&self) -> &Arc<AtomicU64> {
        &self.revision
    }

    fn add_input<T: Message>(&mut self, name: &str, schema: Schema, doc: &str) -> In<T> {
        let declared = &mut self.declaration.inputs;
        let known = declared.iter().position(|port| port.name == name);
        let (input, declaration) = (InputPort::<T>::new(schema.clone()), port(name, schema, doc));
        if let Some(index) = known.filter(|index| self.inherited_inputs.remove(index)) {
            self.inputs[index] = Box::new(input);
            declared[index] = declaration;
            return In::new(self.owner, index);
        }
        self.inputs.push(Box::new(input));
        declared.push(declaration);
        self.check_unique(known.is_some(), "input", name);
        In::new(self.owner, self.inputs.len() - 1)
    }

    fn add_output<T: Message>(&mut self, name: &str, schema: Schema, doc: &str) -> Out<T> {
        let declared = &mut self.declaration.outputs;
        let known = declared.iter().position(|port| port.name == name);
        let (output, declaration) = (
            OutputPort::<T>::new(schema.clone()),
            port(name, schema, doc),
        );
        if let Some(index) = known.filter(|index| self.inherited_outputs.remove(index)) {
            self.outputs[index] = Box::new(output);
            declared[index] = declaration;
            return Out::new(self.owner, index);
        }
        self.outputs.push(Box::new(output));
        declared.push(declaration);
        self.check_unique(known.is_some(), "output", name);
        Out::new(self.owner, self.outputs.len() - 1)
    }

    fn add_provided<O: Operation>(
        &mut self,
        name: &str,
        interface: &str,
        operation: OperationDeclaration,
        handler: Option<Handler>,
        doc: &str,
    ) -> Provided<O> {
        let services = &mut self.declaration.services;
        let port = services.iter().position(|service| service.name == name);
        let port = port.unwrap_or(services.len());
        if port == services.len() {
            services.push(ServiceDeclaration {
                name: name.to_owned(),
                interface: interface.to_owned(),
                doc: doc.to_owned(),
                operations: Vec::new(),
            });
            self.handlers.push(Vec::new());
        }
        self.handlers[port].push(handler);
        let service = &mut services[port];
        let problem = add_operation(
            name,
            &service.interface,
            interface,
            &mut service.operations,
            operation,
        );
        self.problems.extend(problem);
        let operation = service.operations.len() - 1;
        self.provided.push(OperationSlot { port, operation });
        Provided::new(self.owner, self.provided.len() - 1)
    }

    fn add_required<O: Operation>(
        &mut self,
        name: &str,
        interface: &str,
        operation: OperationDeclaration,
        doc: &str,
    ) -> Required<O> {
        let references = &mut self.declaration.references;
        let port = references
            .iter()
            .position(|reference| reference.name == name);
        let port = port.unwrap_or(references.len());
        if port == references.len() {
            references.push(ReferenceDeclaration {
                name: name.to_owned(),
                interface: interface.to_owned(),
                doc: doc.to_owned(),
                optional: false,
                operations: Vec::new(),
            });
        }
        let reference = &mut references[port];
        let is_same = |it: &OperationSlot| {
            it.port == port && reference.operations[it.operation].name == operation.name
        };
        let inherited = self.inherited_operations.iter().position(is_same);
        let operations = &mut reference.operations;
        let operation = match inherited.filter(|_| reference.interface == interface) {
            Some(index) => {
                let slot = self.inherited_operations.swap_remove(index);
                operations[slot.operation] = operation;
                slot.operation
            }
            None => {
                let first = &reference.interface;
                let problem = add_operation(name, first, interface, operations, operation);
                self.problems.extend(problem);
                operations.len() - 1
            }
        };
        self.required.push(OperationSlot { port, operation });
        Required::new(self.owner, self.required.len() - 1)
    }

    pub(crate) fn add_property<T: PropertyValue>(
        &mut self,
        slot: property::Slot<T>,
    ) -> Property<T> {
        let declaration = slot.declaration().clone();
        let known = self.declaration.property(&declaration.name).is_some();
        self.check_unique(known, "property", &declaration.name);
        if let Err(error) = slot.check(&declaration.default) {
            self.problems.push(DeclarationError::InvalidDefault {
                name: declaration.name.clone(),
                reason: error.to_string(),
            });
        }
        self.properties.push(Box::new(slot));
        self.declaration.properties.push(declaration);
        Property::new(self.owner, self.properties.len() - 1)
    }

    /// Converts a property's value to a datum. A value that cannot be represented is recorded as a problem.
    pub(crate) fn datum_of<T: PropertyValue>(&mut self, property: &str, value: &T) -> Datum {
        Datum::of(value).unwrap_or_else(|error| {
            self.problems.push(DeclarationError::InvalidDefault {
                name: property.to_owned(),
                reason: error.to_string(),
            });
            Datum::Null
        })
    }

    fn check_unique(&mut self, is_declared: bool, kind: &'static str, name: &str) {
        if is_declared {
            let name = name.to_owned();
            self.problems
                .push(DeclarationError::Duplicate { kind, name });
        }
    }
}

fn port(name: &str, schema: Schema, doc: &str) -> PortDeclaration {
    PortDeclaration {
        name: name.to_owned(),
        schema,
        doc: doc.to_owned(),
        safe: None,
        command: false,
        optional: false,
    }
}

/// Adds an operation to a service or reference. Returns the contradiction if the interface differs or the name is
/// taken.
fn add_operation(
    name: &str,
    first: &str,
    second: &str,
    operations: &mut Vec<OperationDeclaration>,
    operation: OperationDeclaration,
) -> Option<DeclarationError> {
    let known = operations.iter().any(|known| known.name == operation.name);
    let problem = if first != second {
        Some(DeclarationError::ConflictingInterfaces {
            name: name.to_owned(),
            first: first.to_owned(),
            second: second.to_owned(),
        })
    } else if known {
        Some(DeclarationError::Duplicate {
            kind: "operation",
            name: format!("{name}.{}", operation.name),
        })
    } else {
        None
    };
    operations.push(operation);
    problem
}

impl Default for Interface {
    fn default() -> Self {
        Self::new()
    }
}
