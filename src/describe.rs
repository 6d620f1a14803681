//! What a composite is to the outside: its components, its topics, the operations it serves.

pub mod asyncapi;
mod envelope;
mod spoken;
pub mod yaml;

use std::sync::Arc;

use asmotion_assembly::declaration::{Declaration, OperationDeclaration};
use asmotion_assembly::plan::{Component, End, Implementation, Terminal, Topic};
use asmotion_assembly::{Catalogue, Opened, Plan, Standard, Workshop};
use asmotion_component::{HEALTH_TOPIC, Interface};
use asmotion_datum::{Schema, Shape};
use asmotion_lang::ir::Program;

use crate::build::BUILD;
use crate::files::Disk;

/// A composite as others see it.
pub struct Description<'p> {
    /// What it was made of.
    pub plan: &'p Plan,
    /// What the composite says of itself.
    pub doc: Option<String>,
    /// Everything that is published or subscribed, by name; then what passes between processes.
    pub topics: Vec<Channel>,
    /// Every operation that is served, in the order of the files.
    pub operations: Vec<Served>,
}

/// A topic, and who is on it.
pub struct Channel {
    /// Its name, without the robot's.
    pub name: String,
    /// What passes.
    pub message: Schema,
    /// Who writes.
    pub publishers: Vec<End>,
    /// Who reads.
    pub subscribers: Vec<End>,
}

/// An operation that a component serves, and who calls it.
pub struct Served {
    /// The component and its service.
    pub service: End,
    /// The interface of the service.
    pub interface: String,
    /// The operation: its name, what is asked, what is answered.
    pub operation: OperationDeclaration,
    /// Whether nobody is answered.
    pub one_way: bool,
    /// The references wired to the service.
    pub callers: Vec<Caller>,
}

/// A reference that is wired to a service.
pub struct Caller {
    /// The component and its reference.
    pub reference: End,
    /// How long it waits.
    pub timeout_ms: u64,
    /// Whether it wants no answer.
    pub one_way: bool,
}

impl Served {
    /// Where it is called, without the robot's name.
    pub fn address(&self) -> String {
        format!("{}.{}", self.service, self.operation.name)
    }
}

/// Describes a composite in one profile.
pub fn describe<'p>(opened: &Opened, plan: &'p Plan) -> Description<'p> {
    let declared = Declared::of(opened, plan);
    // how its bus is, a system tells inside
    let topics = plan
        .topics
        .iter()
        .filter(|topic| topic.name != HEALTH_TOPIC);
    let topics = topics.map(|topic| declared.topic(topic));
    let crossings = declared.crossings();
    let doc = opened.composite.as_ref().and_then(|it| it.doc.as_ref());
    Description {
        plan,
        doc: doc.map(|doc| doc.value.clone()),
        topics: topics.chain(crossings).collect(),
        operations: (plan.components.iter())
            .flat_map(|component| declared.served(component))
            .collect(),
    }
}

/// What the components of a plan declare; nothing of those that are not of this build.
struct Declared<'a> {
    opened: &'a Opened,
    plan: &'a Plan,
    components: Vec<Option<Declaration>>,
}

impl<'a> Declared<'a> {
    fn of(opened: &'a Opened, plan: &'a Plan) -> Self {
        let components = plan.components.iter();
        Self {
            opened,
            plan,
            components: components
                .map(|component| declaration(component, plan))
                .collect(),
        }
    }

    fn component(&self, name: &str) -> Option<&Declaration> {
        let position = self.plan.components.iter().position(|it| it.name == name)?;
        self.components.get(position)?.as_ref()
    }

    /// What passes through a port, if its component says.
    fn port(&self, end: &End) -> Option<&Schema> {
        let declared = self.component(&end.component)?;
        let port = (declared.output(&end.name)).or_else(|| declared.input(&end.name))?;
        Some(&port.schema)
    }

    /// The shape of a type that is known by name, if the build or the composite has it.
    fn known(&self, schema: Schema) -> Schema {
        match schema.shape {
            Shape::Any => self.opened.schema(&schema.name).cloned().unwrap_or(schema),
            _ => schema,
        }
    }

    /// What passes between these ports: who has the type itself knows it best.
    fn message<'e>(&self, ends: impl Iterator<Item = &'e End>, kind: Option<&str>) -> Schema {
        let mut schemas = ends.filter_map(|end| self.port(end));
        match schemas.find(|schema| schema.shape != Shape::Any) {
            Some(schema) => schema.clone(),
            None => self.known(Schema::opaque(kind.unwrap_or_default().to_owned())),
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

    /// Connections of ports that are not in one process: each output is a topic of its own.
    fn crossings(&self) -> Vec<Channel> {
        let process = |component: &str| {
            let mut processes = self.plan.processes.iter();
            processes.position(|process| process.components.iter().any(|it| it == component))
        };
        let mut crossings: Vec<Channel> = Vec::new();
        for connection in &self.plan.connections {
            let (Terminal::Port(from), Terminal::Port(to)) = (&connection.from, &connection.to)
            else {
                continue;
            };
            if process(&from.component) == process(&to.component) {
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

    /// The operations that a component serves: as it declares them, or as the interfaces of its services have them.
    fn served(&self, component: &Component) -> Vec<Served> {
        let services: Vec<_> = match self.component(&component.name) {
            Some(declared) => (declared.services.iter())
                .map(|it| (&it.name, &it.interface, it.operations.clone()))
                .collect(),
            None => (component.services.iter())
                .map(|it| {
                    let operations = BUILD.operations(&it.interface).unwrap_or_default();
                    (&it.name, &it.interface, operations)
                })
                .collect(),
        };
        let program = program(component);
        let mut served = Vec::new();
        for (name, interface, operations) in services {
            let service = End {
                component: component.name.clone(),
                name: name.clone(),
            };
            served.extend(operations.into_iter().map(|operation| {
                let spoken = program.as_ref();
                let spoken = spoken.map(|program| spoken::operation(program, &operation.name));
                let one_way = spoken.as_ref().is_some_and(|spoken| spoken.one_way);
                let (request, response) = match spoken {
                    Some(spoken) => (spoken.request, spoken.response),
                    None => (operation.request, operation.response),
                };
                Served {
                    callers: self.callers(&service, &operation.name),
                    service: service.clone(),
                    interface: interface.clone(),
                    operation: OperationDeclaration {
                        request: self.known(request),
                        response: self.known(response),
                        name: operation.name,
                    },
                    one_way,
                }
            }));
        }
        served
    }

    /// Who is wired to a service and calls the operation; who does not say what it calls may call any.
    fn callers(&self, service: &End, operation: &str) -> Vec<Caller> {
        let calls = |reference: &End| {
            let declared = self.component(&reference.component);
            let declared = declared.map(|it| it.reference(&reference.name));
            match declared {
                None => true,
                Some(None) => false,
                Some(Some(reference)) => {
                    (reference.operations.iter()).any(|it| it.name == operation)
                }
            }
        };
        let wires = self.plan.wires.iter();
        let wires = wires.filter(|it| it.services.contains(service) && calls(&it.reference));
        wires
            .map(|wire| Caller {
                reference: wire.reference.clone(),
                timeout_ms: wire.timeout_ms,
                one_way: wire.oneway,
            })
            .collect()
    }
}

/// The program of a component that runs a specification.
fn program(component: &Component) -> Option<Arc<Program>> {
    let Implementation::Asm(asm) = &component.implementation else {
        return None;
    };
    Some(asmotion_lang::open(&asm.path, &Disk).ok()?.program)
}

/// What a component declares; `None` where it cannot be made here, such as a ROS node.
fn declaration(component: &Component, plan: &Plan) -> Option<Declaration> {
    let mut workshop = Standard {
        catalogue: &BUILD,
        loader: &Disk,
        seed: 0,
        builtins: &mut |_, _| None,
    };
    let make = workshop.make(component, plan).ok()?;
    let mut scratch = Interface::new();
    make(&mut scratch).ok()?;
    Some(scratch.declaration().clone())
}

/// What a component is made of, for people.
pub fn implementation(component: &Component) -> String {
    match &component.implementation {
        Implementation::Rust(name) => name.clone(),
        Implementation::Asm(asm) => {
            let file = std::path::Path::new(&asm.path).file_name();
            file.map_or(asm.path.clone(), |name| name.to_string_lossy().into_owned())
        }
        Implementation::Builtin(settings) => settings.kind.to_string(),
        Implementation::Process(words)
        | Implementation::Ros(words)
        | Implementation::Orocos(words) => words.join(" "),
    }
}
