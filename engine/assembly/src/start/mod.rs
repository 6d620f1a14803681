//! Creation of a runnable system from a plan: components, property values, connections and wires.

mod activity;
mod coordinator;
mod policy;
mod program;
mod queue;
mod sending;
mod specifications;
mod workshop;

use std::time::Duration;

use asmotion_component::declaration::{Declaration, OperationDeclaration};
use asmotion_component::{Component, Interface, Policy, PropertyError, Wire};
use asmotion_coordinator::{Monitored, Receive, Source};
use asmotion_network::{Network, port_topic};
use asmotion_runtime::{BuildError, ComponentId, System};

use asmotion_composite::model::{self, Transport};
use asmotion_plan::{InputQueue, Part, Plan, Terminal, WireList, robot_address};

pub(crate) use activity::of as activity;
pub(crate) use policy::of as policy;
pub(crate) use sending::{of_port as port_sending, of_topics as topic_sending};
pub(crate) use specifications::texts as specification_texts;
pub use workshop::{Builtins, CoordinatorOptions, Make, Standard, Workshop};

/// The error type of starting a plan.
#[derive(Debug, thiserror::Error)]
pub enum StartError {
    /// Environment variables are not set.
    #[error("environment variables not set: {}", variables.join(", "))]
    Missing {
        /// Names of the variables.
        variables: Vec<String>,
    },
    /// A component could not be created.
    #[error("`{component}` cannot be created: {reason}")]
    NotMade {
        /// Component name.
        component: String,
        /// Human-readable reason.
        reason: String,
    },
    /// The executable does not support the transport of a wire.
    #[error("the wire of `{reference}` uses `{binding}`, which is not in this build")]
    Binding {
        /// Reference of the wire.
        reference: String,
        /// Unsupported transport.
        binding: model::Transport,
    },
    /// The executable does not support a transport of a promotion.
    #[error("the promotion `{name}` uses `{binding}`, which is not in this build")]
    PromotionBinding {
        /// Public name.
        name: String,
        /// Unsupported transport.
        binding: model::Transport,
    },
    /// A property rejected its value.
    #[error("`{component}`: {source}")]
    Property {
        /// Component name.
        component: String,
        /// Reason for the rejection.
        source: PropertyError,
    },
    /// A message queue could not be connected to a port.
    #[error("`{port}`: {reason}")]
    Queue {
        /// Port, displayed as `Component.port`.
        port: String,
        /// Human-readable reason.
        reason: String,
    },
    /// The components do not form a valid system.
    #[error(transparent)]
    Build(#[from] BuildError),
}

/// Capacity of a subscription in messages, unless the composite writes a queue for it or for the writers of the topic; the
/// oldest messages are dropped.
pub const SUBSCRIPTION_SIZE: usize = 64;

/// The same of a subscription that supplies events of a specification (`receive = "all"`).
pub const EVENTS_SIZE: usize = 256;

/// Creates the system of a plan in this process, to be simulated or run live. Components keep the file order.
///
/// # Errors
///
/// The first error encountered. [`StartError::Binding`] if a wire leads to another system or robot, for which the system needs
/// a client ([`Network::connect_clients`]) or a bus ([`Network::attach`]).
pub fn start(plan: &Plan, workshop: &mut dyn Workshop) -> Result<System, StartError> {
    if let Some(wire) = plan.wires.iter().find(|wire| wire.url.is_some()) {
        return Err(StartError::Binding {
            reference: wire.reference.to_string(),
            binding: wire.binding,
        });
    }
    start_part(plan, &Part::Whole, workshop).map(|assembled| assembled.system)
}

/// A part of a plan, ready to be connected to its buses and run.
pub struct Assembled {
    /// Connected components of the part.
    pub system: System,
    /// Connections to the rest of the plan over buses.
    pub network: Network,
}

/// Creates the system of a part of a plan and its connections to the rest over a bus.
///
/// # Errors
///
/// The first error encountered.
pub fn start_part(
    plan: &Plan,
    part: &Part,
    workshop: &mut dyn Workshop,
) -> Result<Assembled, StartError> {
    if !plan.missing.is_empty() {
        return Err(StartError::Missing {
            variables: plan.missing.clone(),
        });
    }
    let binding = model::Transport::Ros;
    if let Some(promoted) = plan
        .promoted
        .iter()
        .find(|it| it.bindings.contains(&binding))
    {
        let name = promoted.name.clone();
        return Err(StartError::PromotionBinding { name, binding });
    }
    let mut building = Building {
        plan,
        part,
        system: System::new(),
        network: Network::new(),
    };
    if part.takes_the_bus_inside() {
        building.system.leave_topics_to_adapters();
    }
    let here = |component: &&asmotion_plan::Component| part.has(&component.name);
    for component in plan.components.iter().filter(here) {
        building.component(component, workshop)?;
    }
    for component in plan.components.iter().filter(here) {
        if let Some(master) = &component.pace.master {
            building.system.add_slave(&component.name, master)?;
        }
    }
    for component in plan.components.iter().filter(here) {
        building.topics(component)?;
        building.services(component)?;
    }
    for connection in &plan.connections {
        building.connection(connection)?;
    }
    for (topic, sending) in sending::of_topics(plan, part) {
        building.network.set_publish_options(topic, sending);
    }
    for wire in &plan.wires {
        building.wire(wire, workshop)?;
    }
    Ok(Assembled {
        system: building.system,
        network: building.network,
    })
}

struct Building<'p> {
    plan: &'p Plan,
    part: &'p Part,
    system: System,
    network: Network,
}

impl Building<'_> {
    fn component(
        &mut self,
        component: &asmotion_plan::Component,
        workshop: &mut dyn Workshop,
    ) -> Result<(), StartError> {
        let not_made = |reason| StartError::NotMade {
            component: component.name.clone(),
            reason,
        };
        let make = workshop.make(component, self.plan).map_err(not_made)?;
        let mut failed = None;
        let id = self.system.add(
            &component.name,
            activity::of(component, self.plan),
            |interface| {
                make(interface).unwrap_or_else(|reason| {
                    failed = Some(reason);
                    Box::new(Nothing)
                })
            },
        )?;
        if let Some(reason) = failed {
            return Err(not_made(reason));
        }
        self.system.set_external_name(id, &component.id);
        if let Some(broker) = self.plan.broker_of(&component.name) {
            self.network.assign_bus(id, broker);
        }
        for (name, value) in &component.properties.0 {
            let set = self.system.set_property(id, name, &value.datum());
            set.map_err(|source| StartError::Property {
                component: component.name.clone(),
                source,
            })?;
        }
        for (output, sample) in &component.lifecycle.safe {
            let output = format!("{}.{output}", component.name);
            self.system.set_safe_sample(&output, &sample.datum())?;
        }
        Ok(())
    }

    /// Connects ports that are on a topic without an explicit connection.
    fn topics(&mut self, component: &asmotion_plan::Component) -> Result<(), StartError> {
        for port in &component.outputs {
            let end = end(component, &port.name);
            if let Some(topic) = &port.topic
                && self.has(&component.name, |declared| {
                    declared.output(&port.name).is_some()
                })
                && !self.is_connected(
                    &Terminal::Port(end.clone()),
                    &Terminal::Topic(topic.clone()),
                )
            {
                self.system.publish(&end.to_string(), topic)?;
            }
        }
        for port in &component.inputs {
            let end = end(component, &port.name);
            if let Some(topic) = &port.topic
                && self.has(&component.name, |declared| {
                    declared.input(&port.name).is_some()
                })
                && !self.is_connected(
                    &Terminal::Topic(topic.clone()),
                    &Terminal::Port(end.clone()),
                )
            {
                let policy = subscription_policy(self.plan, component, &port.name, topic);
                self.system.subscribe(topic, &end.to_string(), policy)?;
            }
        }
        Ok(())
    }

    /// Returns whether a connection of its own joins two terminals; its policy is then that of the subscription.
    fn is_connected(&self, from: &Terminal, to: &Terminal) -> bool {
        let mut connections = self.plan.connections.from_end(from);
        connections.any(|it| it.to == *to)
    }

    /// Makes the services of a component available outside this part.
    fn services(&mut self, component: &asmotion_plan::Component) -> Result<(), StartError> {
        if self.part.is_alone() {
            return Ok(());
        }
        for service in &component.services {
            if self.has(&component.name, |declared| {
                declared.service(&service.name).is_some()
            }) {
                let end = format!("{}.{}", component.name, service.name);
                let doors = self.plan.doors(&component.name, &service.name, self.part);
                for (name, broker) in doors {
                    self.network.offer_as(&self.system, &end, &name, broker)?;
                }
            }
        }
        Ok(())
    }

    /// Returns whether the created component declares an element; it may omit elements it does not use.
    fn has(&self, component: &str, what: impl Fn(&Declaration) -> bool) -> bool {
        let id: Option<ComponentId> = self.system.id(component);
        id.and_then(|id| self.system.declaration(id))
            .is_some_and(what)
    }

    fn connection(&mut self, connection: &asmotion_plan::Connection) -> Result<(), StartError> {
        let joint = &connection.policy;
        let policy = policy::of(connection);
        match (&connection.from, &connection.to) {
            (Terminal::Port(from), Terminal::Port(to)) => self.ports(from, to, policy)?,
            (Terminal::Port(from), Terminal::Mqueue(queue)) if self.part.has(&from.component) => {
                queue::to(&mut self.system, from, queue, joint)?;
            }
            (Terminal::Mqueue(queue), Terminal::Port(to)) if self.part.has(&to.component) => {
                queue::from(&mut self.system, queue, to, &policy)?;
            }
            (Terminal::Port(from), Terminal::Topic(topic)) if self.part.has(&from.component) => {
                self.system.publish(&from.to_string(), topic)?;
            }
            (Terminal::Topic(topic), Terminal::Port(to)) if self.part.has(&to.component) => {
                self.system.subscribe(topic, &to.to_string(), policy)?;
            }
            // the others belong to another part; connections without a component are rejected by the checker
            (_, Terminal::Topic(_) | Terminal::Mqueue(_))
            | (Terminal::Topic(_) | Terminal::Mqueue(_), Terminal::Port(_)) => {}
        }
        Ok(())
    }

    /// Connects two ports, one or both of which may be in another part.
    fn ports(
        &mut self,
        from: &asmotion_plan::End,
        to: &asmotion_plan::End,
        policy: Policy,
    ) -> Result<(), BuildError> {
        let (writer, reader) = (from.to_string(), to.to_string());
        match (self.part.has(&from.component), self.part.has(&to.component)) {
            (true, true) => self.system.connect(&writer, &reader, policy),
            (true, false) => {
                let sending = sending::of_port(self.plan, from);
                self.network.expose(&self.system, &writer, sending)
            }
            (false, true) => self.system.subscribe(&port_topic(&writer), &reader, policy),
            (false, false) => Ok(()),
        }
    }

    fn wire(
        &mut self,
        wire: &asmotion_plan::Wire,
        workshop: &dyn Workshop,
    ) -> Result<(), StartError> {
        let reference = &wire.reference;
        if !self.part.has(&reference.component) {
            return Ok(());
        }
        if !self.has(&reference.component, |declared| {
            declared.reference(&reference.name).is_some()
        }) {
            return Ok(());
        }
        let how = how(&self.plan.wires, wire);
        let broker = self.plan.broker_of_wire(wire);
        let caller = reference.to_string();
        self.wire_outside(wire, how, workshop)?;
        for service in &wire.services {
            let provider = service.to_string();
            if stays_here(wire, service, self.part) {
                self.system.wire(&caller, &provider, how)?
            } else {
                let known = operations(self.plan, workshop);
                let system = &mut self.system;
                self.network
                    .wire_remote_over(system, &caller, &provider, how, broker, &known)?;
            }
        }
        Ok(())
    }

    /// Wires a reference to a service of another system or robot, if the wire leads to one.
    fn wire_outside(
        &mut self,
        wire: &asmotion_plan::Wire,
        how: Wire,
        workshop: &dyn Workshop,
    ) -> Result<(), StartError> {
        let caller = wire.reference.to_string();
        let (system, network) = (&mut self.system, &mut self.network);
        match (wire.binding, &wire.url) {
            (Transport::Http, Some(url)) => {
                let known = operations(self.plan, workshop);
                let url = (url.reveal(), url.shown());
                network.wire_external(system, &caller, url, how, &known)?;
            }
            (Transport::Amqp, Some(_)) => {
                if let Some(service) = robot_address(wire) {
                    let broker = self.plan.broker_of_wire(wire);
                    let known = operations(self.plan, workshop);
                    network.wire_to_robot(system, &caller, service, how, broker, &known)?;
                }
            }
            (Transport::Local | Transport::Amqp, _) => {}
            (binding @ (Transport::Ros | Transport::Http), _) => {
                return Err(StartError::Binding {
                    reference: caller,
                    binding,
                });
            }
        }
        Ok(())
    }
}

/// The operations of service interfaces: those of the workshop, and those that only the plan has.
fn operations<'p>(
    plan: &'p Plan,
    workshop: &'p dyn Workshop,
) -> impl Fn(&str) -> Option<Vec<OperationDeclaration>> + 'p {
    move |interface| {
        let of_plan = || plan.interfaces.get(interface).cloned();
        workshop.operations(interface).or_else(of_plan)
    }
}

/// The policy of an input that is on a topic without an explicit connection: a queue as large as those of the connections
/// into the topic together, or of the default size if one of them has none.
pub(crate) fn subscription_policy(
    plan: &Plan,
    component: &asmotion_plan::Component,
    port: &str,
    topic: &str,
) -> Policy {
    match plan.topic_queue(topic) {
        None => Policy::circular(default_size(component, port)),
        Some(InputQueue { size, is_circular }) => {
            let size = usize::try_from(size).unwrap_or(usize::MAX);
            if is_circular {
                Policy::circular(size)
            } else {
                Policy::buffer(size)
            }
        }
    }
}

fn default_size(component: &asmotion_plan::Component, port: &str) -> usize {
    let monitored = component.binding.iter().flat_map(|it| &it.monitored);
    let is_event = |it: &Monitored| {
        it.receive == Receive::All && matches!(&it.from, Source::Port(name) if name == port)
    };
    if monitored.filter(|it| is_event(it)).count() > 0 {
        EVENTS_SIZE
    } else {
        SUBSCRIPTION_SIZE
    }
}

/// Converts the timeout and retries of one of these wires. Several wires of a reference are its alternatives, in this
/// order.
pub(crate) fn how(wires: &WireList, wire: &asmotion_plan::Wire) -> Wire {
    let same = wires.of_reference(&wire.reference);
    let before = same.take_while(|it| !std::ptr::eq(*it, wire));
    Wire {
        timeout: Duration::from_millis(wire.timeout_ms),
        retries: u32::try_from(wire.retry.attempts).unwrap_or(u32::MAX),
        backoff: Duration::from_millis(wire.retry.backoff_ms),
        cancel_on_timeout: wire.cancel == model::Cancel::OnTimeout,
        one_way: wire.oneway,
        alternative: u32::try_from(before.count()).unwrap_or(u32::MAX),
    }
}

/// Returns whether a service is called within this part without a bus.
pub(crate) fn stays_here(
    wire: &asmotion_plan::Wire,
    service: &asmotion_plan::End,
    part: &Part,
) -> bool {
    let abroad = part.takes_the_bus_inside() || (wire.goes_abroad() && !part.is_alone());
    part.has(&service.component) && !abroad
}

/// Placeholder for a component that could not be created, until the error is reported.
struct Nothing;

impl Component for Nothing {
    fn update(
        &mut self,
        _: &mut asmotion_component::Cycle<'_>,
    ) -> Result<(), asmotion_component::Fault> {
        Ok(())
    }
}

/// Creates a component by its factory in the catalogue.
fn of_build(factory: asmotion_composite::ComponentFactory) -> Make {
    Box::new(move |interface: &mut Interface| Ok(factory(interface)))
}

fn end(component: &asmotion_plan::Component, name: &str) -> asmotion_plan::End {
    asmotion_plan::End {
        component: component.name.clone(),
        name: name.to_owned(),
    }
}
