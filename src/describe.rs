//! The external interface of a composite: components, topics and served operations.

pub mod asyncapi;
mod cpp;
mod envelope;
pub mod language;
mod operation_types;
mod python;
pub mod types;
mod typescript;
pub mod yaml;

use std::collections::BTreeMap;
use std::sync::Arc;

use asmotion_assembly::{CoordinatorOptions, Standard, Workshop};
use asmotion_component::declaration::{Declaration, OperationDeclaration};
use asmotion_component::{HEALTH_TOPIC, Interface};
use asmotion_composite::Catalogue;
use asmotion_coordinator::Source;
use asmotion_datum::{Schema, Shape};
use asmotion_lang::ir::Program;
use asmotion_plan::{Component, End, Implementation, Opened, Plan, Terminal, Topic};

use self::operation_types::OperationTypes;
use crate::bridges;
use crate::build::Build;
use crate::files::DiskLoader;

/// Description of a composite.
pub struct Description<'p> {
    /// The plan it describes.
    pub plan: &'p Plan,
    /// Documentation text of the composite.
    pub doc: Option<String>,
    /// All topics by name, then the connections between processes.
    pub topics: Vec<Channel>,
    /// All served operations, in the order of the files.
    pub operations: Vec<ServedOperation>,
    /// Message types of the ports.
    ports: Vec<Schema>,
    /// Operations of the references, by interface.
    called: BTreeMap<String, Vec<OperationDeclaration>>,
}

impl Description<'_> {
    /// Message types of topics and ports.
    fn messages(&self) -> impl Iterator<Item = &Schema> {
        let topics = self.topics.iter().map(|topic| &topic.message);
        topics.chain(&self.ports)
    }

    /// Operations of all services and references, by interface.
    fn interfaces(&self) -> BTreeMap<String, Vec<OperationDeclaration>> {
        let mut interfaces = self.called.clone();
        for served in &self.operations {
            let operations = interfaces.entry(served.interface.clone()).or_default();
            match operations
                .iter_mut()
                .find(|it| it.name == served.operation.name)
            {
                Some(known) => known.clone_from(&served.operation),
                None => operations.push(served.operation.clone()),
            }
        }
        interfaces
    }
}

/// A topic with its publishers and subscribers.
pub struct Channel {
    /// Name without the robot's name.
    pub name: String,
    /// Schema of the messages.
    pub message: Schema,
    /// Publishing ports.
    pub publishers: Vec<End>,
    /// Subscribing ports.
    pub subscribers: Vec<End>,
}

/// An operation served by a component, and its callers.
pub struct ServedOperation {
    /// Component and service.
    pub service: End,
    /// Interface of the service.
    pub interface: String,
    /// Declaration: name, request and response.
    pub operation: OperationDeclaration,
    /// Whether the operation has no reply.
    pub one_way: bool,
    /// References wired to the service.
    pub callers: Vec<OperationCaller>,
}

/// A reference wired to a service.
pub struct OperationCaller {
    /// Component and reference.
    pub reference: End,
    /// Deadline of its calls.
    pub timeout_ms: u64,
    /// Whether it expects no reply.
    pub one_way: bool,
}

impl ServedOperation {
    /// Address without the robot's name.
    pub fn address(&self) -> String {
        format!("{}.{}", self.service, self.operation.name)
    }
}

/// Describes one profile of a composite.
pub fn describe<'p>(build: &Build, opened: &Opened, plan: &'p Plan) -> Description<'p> {
    let catalogue = build.catalogue();
    let declared = Declarations::of(catalogue, opened, plan);
    // the topic `bus` never leaves its process
    let topics = plan
        .topics
        .iter()
        .filter(|topic| topic.name != HEALTH_TOPIC);
    let topics = topics.map(|topic| declared.topic(topic));
    let crossings = declared.crossings();
    let doc = opened
        .composite
        .as_ref()
        .and_then(|it| it.head.doc.as_ref());
    Description {
        plan,
        doc: doc.map(|doc| doc.value.clone()),
        topics: topics.chain(crossings).collect(),
        operations: plan
            .components
            .iter()
            .flat_map(|component| declared.served(component))
            .collect(),
        ports: declared.ports(),
        called: declared.called(),
    }
}

/// Declarations of the plan's components, as far as this binary contains them.
struct Declarations<'a> {
    catalogue: &'a dyn Catalogue,
    opened: &'a Opened,
    plan: &'a Plan,
    components: Vec<Option<Declaration>>,
    /// Programs of the specifications with services, by file; `None` if one cannot be read.
    programs: BTreeMap<&'a str, Option<Arc<Program>>>,
}

impl<'a> Declarations<'a> {
    fn of(catalogue: &'a dyn Catalogue, opened: &'a Opened, plan: &'a Plan) -> Self {
        let mut builtins =
            |component: &Component, plan: &Plan| bridges::make(catalogue, component, plan);
        // reads each specification once
        let workshop = Standard::new(catalogue, &DiskLoader, CoordinatorOptions::seeded(0));
        let mut workshop = workshop.with_builtins(&mut builtins);
        let (mut components, mut programs) = (Vec::new(), BTreeMap::new());
        for component in &plan.components {
            components.push(declaration(&mut workshop, component, plan));
            if let Implementation::Asm { file, .. } = &component.implementation
                && !component.services.is_empty()
            {
                programs.entry(&**file).or_insert_with(|| program(file));
            }
        }
        Self {
            catalogue,
            opened,
            plan,
            components,
            programs,
        }
    }

    /// The program of a component that runs a specification.
    fn program(&self, component: &Component) -> Option<&Program> {
        match &component.implementation {
            Implementation::Asm { file, .. } => self.programs.get(&**file)?.as_deref(),
            Implementation::Rust(_)
            | Implementation::Builtin { .. }
            | Implementation::Process { .. }
            | Implementation::Ros { .. }
            | Implementation::Orocos { .. } => None,
        }
    }

    fn component(&self, name: &str) -> Option<&Declaration> {
        let position = self.plan.components.position(name)?;
        self.components.get(position)?.as_ref()
    }

    /// Schema of a port, if its component declares it.
    fn port(&self, end: &End) -> Option<&Schema> {
        let declared = self.component(&end.component)?;
        let port = declared
            .output(&end.name)
            .or_else(|| declared.input(&end.name))?;
        Some(&port.schema)
    }

    /// Replaces a reference to a named type by its definition, if this binary or the composite has one.
    fn resolve_named(&self, schema: Schema) -> Schema {
        if schema.shape == Shape::Any {
            self.opened.schema(&schema.name).cloned().unwrap_or(schema)
        } else {
            schema
        }
    }

    /// Schema shared by these ports. A declared schema takes precedence over a name.
    fn message<'e>(&self, ends: impl Iterator<Item = &'e End>, kind: Option<&str>) -> Schema {
        let mut schemas = ends.filter_map(|end| self.port(end));
        match schemas.find(|schema| schema.shape != Shape::Any) {
            Some(schema) => schema.clone(),
            None => self.resolve_named(Schema::opaque(kind.unwrap_or_default().to_owned())),
        }
    }

    fn topic(&self, topic: &Topic) -> Channel {
        let ends = topic.publishers.iter().chain(&topic.subscribers);
        Channel {
            name: topic.name.clone(),
            message: self.message(ends, topic.kind.as_deref()),
            publishers: topic.publishers.clone(),
            subscribers: topic.subscribers.clone(),
        }
    }

    /// Message types of all ports.
    fn ports(&self) -> Vec<Schema> {
        let declared = self.components.iter().flatten();
        let declared = declared.flat_map(|it| it.inputs.iter().chain(&it.outputs));
        let declared = declared.map(|port| self.resolve_named(port.schema.clone()));
        let named = self.plan.components.iter();
        let named = named.flat_map(|it| it.inputs.iter().chain(&it.outputs));
        let named = named.map(|port| self.resolve_named(Schema::opaque(port.kind.clone())));
        declared.chain(named).collect()
    }

    /// Operations of all declared references, by interface.
    fn called(&self) -> BTreeMap<String, Vec<OperationDeclaration>> {
        let mut called: BTreeMap<String, Vec<OperationDeclaration>> = BTreeMap::new();
        let declared = self.components.iter().flatten();
        for reference in declared.flat_map(|it| &it.references) {
            let operations = called.entry(reference.interface.clone()).or_default();
            for operation in &reference.operations {
                if !operations.iter().any(|known| known.name == operation.name) {
                    operations.push(OperationDeclaration {
                        request: self.resolve_named(operation.request.clone()),
                        response: self.resolve_named(operation.response.clone()),
                        ..operation.clone()
                    });
                }
            }
        }
        called
    }

    /// Connections between processes: each output is a topic of its own.
    fn crossings(&self) -> Vec<Channel> {
        let process = |end: &End| self.plan.process_of(&end.component).map(|it| &it.name);
        let mut crossings: Vec<Channel> = Vec::new();
        for connection in &self.plan.connections {
            let (Terminal::Port(from), Terminal::Port(to)) = (&connection.from, &connection.to)
            else {
                continue;
            };
            if process(from) == process(to) {
                continue;
            }
            let name = format!("port.{from}");
            match crossings.iter_mut().find(|known| known.name == name) {
                Some(known) => known.subscribers.push(to.clone()),
                None => crossings.push(Channel {
                    name,
                    message: self.message([from, to].into_iter(), None),
                    publishers: vec![from.clone()],
                    subscribers: vec![to.clone()],
                }),
            }
        }
        crossings
    }

    /// Operations served by a component, from its declaration or from the interfaces of its services.
    fn served(&self, component: &Component) -> Vec<ServedOperation> {
        let services: Vec<_> = match self.component(&component.name) {
            Some(declared) => declared
                .services
                .iter()
                .map(|it| (&it.name, &it.interface, it.operations.clone()))
                .collect(),
            None => component
                .services
                .iter()
                .map(|it| {
                    let operations = self.operations(&it.interface);
                    (&it.name, &it.interface, operations)
                })
                .collect(),
        };
        let program = self.program(component);
        let mut served = Vec::new();
        for (name, interface, operations) in services {
            let service = End {
                component: component.name.clone(),
                name: name.clone(),
            };
            served.extend(operations.into_iter().map(|operation| {
                let types = program.map(|program| {
                    self.types_of_operation(
                        component,
                        program,
                        &service,
                        interface,
                        &operation.name,
                    )
                });
                let one_way = types.as_ref().is_some_and(|types| types.one_way);
                let (request, response) = match types {
                    Some(types) => (types.request, types.response),
                    None => (operation.request, operation.response),
                };
                ServedOperation {
                    callers: self.callers(&service, &operation.name),
                    service: service.clone(),
                    interface: interface.clone(),
                    operation: OperationDeclaration {
                        while_stopped: operation.while_stopped,
                        request: self.resolve_named(request),
                        response: self.resolve_named(response),
                        name: operation.name,
                    },
                    one_way,
                }
            }));
        }
        served
    }

    /// Types of an operation of a specification. Requests that are bound to a monitored function have those of the interface
    /// or, if it is unknown, the domain of the function.
    fn types_of_operation(
        &self,
        component: &Component,
        program: &Program,
        service: &End,
        interface: &str,
        operation: &str,
    ) -> OperationTypes {
        let bound = component.binding.iter().flat_map(|it| &it.monitored);
        let mut bound = bound.filter(|it| {
            matches!(&it.from, Source::Request(of)
                if of.service == service.name && of.operation == operation)
        });
        let Some(first) = bound.next() else {
            return operation_types::operation(program, operation);
        };
        let known = self.operations(interface);
        match known.into_iter().find(|it| it.name == operation) {
            Some(known) => OperationTypes {
                request: known.request,
                response: known.response,
                one_way: false,
            },
            None => operation_types::bound(program, std::iter::once(first).chain(bound)),
        }
    }

    /// The operations of an interface, of this build or of a program; none if it is unknown.
    fn operations(&self, interface: &str) -> Vec<OperationDeclaration> {
        let of_folders = self.plan.interfaces.get(interface).cloned();
        let of_build = self.catalogue.operations(interface).or(of_folders);
        let programs = self.plan.components.iter();
        let declared = programs.filter_map(|it| Some(&it.program.as_ref()?.declaration));
        let of_programs = declared.flat_map(|it| {
            let services = it.services.iter().map(|it| (&it.interface, &it.operations));
            let references = it.references.iter();
            services.chain(references.map(|it| (&it.interface, &it.operations)))
        });
        let of_programs = || {
            let mut found = of_programs.filter(|(known, _)| *known == interface);
            found.next().map(|(_, operations)| operations.clone())
        };
        of_build.or_else(of_programs).unwrap_or_default()
    }

    /// References wired to a service that call the operation. A reference without declared calls can call any
    /// operation.
    fn callers(&self, service: &End, operation: &str) -> Vec<OperationCaller> {
        let calls = |reference: &End| {
            let declared = self.component(&reference.component);
            let declared = declared.map(|it| it.reference(&reference.name));
            match declared {
                None => true,
                Some(None) => false,
                Some(Some(reference)) => reference.operations.iter().any(|it| it.name == operation),
            }
        };
        let wires = self.plan.wires.to_service(service);
        let wires = wires.filter(|it| calls(&it.reference));
        wires
            .map(|wire| OperationCaller {
                reference: wire.reference.clone(),
                timeout_ms: wire.timeout_ms,
                one_way: wire.oneway,
            })
            .collect()
    }
}

/// The program of a specification.
fn program(file: &str) -> Option<Arc<Program>> {
    Some(asmotion_lang::open(file, &DiskLoader).ok()?.program)
}

/// The declaration of a component; `None` if this binary cannot create it, for example a ROS node.
fn declaration(
    workshop: &mut dyn Workshop,
    component: &Component,
    plan: &Plan,
) -> Option<Declaration> {
    let make = workshop.make(component, plan).ok()?;
    let mut scratch = Interface::new();
    make(&mut scratch).ok()?;
    Some(scratch.declaration().clone())
}

/// The implementation of a component as text.
pub fn implementation(component: &Component) -> String {
    if let Implementation::Asm { file, .. } = &component.implementation {
        let name = std::path::Path::new(file).file_name();
        return name.map_or(file.clone(), |name| name.to_string_lossy().into_owned());
    }
    let words = component.implementation.words().into_iter();
    words
        .chain(stands_for(component))
        .collect::<Vec<_>>()
        .join(" ")
}

/// The component that a proxy or a stand-in stands for, or the bridge of a ros-bridge.
fn stands_for(component: &Component) -> Option<&str> {
    let Implementation::Builtin { target, bridge, .. } = &component.implementation else {
        return None;
    };
    target.as_deref().or(bridge.as_deref())
}
