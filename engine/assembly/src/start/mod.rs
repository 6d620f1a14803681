//! A plan becomes a system: components are made, given their properties, joined and wired.

mod activity;
mod coordinator;
mod policy;
mod queue;
mod sending;
mod workshop;

use std::time::Duration;

use asmotion_component::declaration::Declaration;
use asmotion_component::{Component, Interface, Policy, PropertyError, Wire};
use asmotion_network::{Network, port_topic};
use asmotion_runtime::{BuildError, ComponentId, System};

use asmotion_composite::model::{self, Transport};
use asmotion_plan::{Part, Plan, Terminal};

pub(crate) use activity::of as activity;
pub(crate) use policy::of as policy;
pub use workshop::{Make, Standard, Workshop};

/// Why a plan cannot be started.
#[derive(Debug, thiserror::Error)]
pub enum StartError {
    /// Something that must come from the environment is not there.
    #[error("environment variables not set: {}", variables.join(", "))]
    Missing {
        /// The variables.
        variables: Vec<String>,
    },
    /// A component could not be made.
    #[error("`{component}` cannot be created: {reason}")]
    NotMade {
        /// The component.
        component: String,
        /// Why.
        reason: String,
    },
    /// What a wire goes over is not in this build.
    #[error("the wire of `{reference}` uses `{binding}`, which is not in this build")]
    Binding {
        /// The reference.
        reference: String,
        /// Over what.
        binding: model::Transport,
    },
    /// A property does not take its value.
    #[error("`{component}`: {source}")]
    Property {
        /// The component.
        component: String,
        /// Why.
        source: PropertyError,
    },
    /// A message queue cannot be joined to a port.
    #[error("`{port}`: {reason}")]
    Queue {
        /// The port.
        port: String,
        /// Why.
        reason: String,
    },
    /// The system does not go together.
    #[error(transparent)]
    Build(#[from] BuildError),
}

/// How many messages wait for a subscriber between two of its cycles; the oldest go first.
pub const SUBSCRIPTION_SIZE: usize = 64;

/// Builds the system of a plan, all of it in this process: `simulate` it, or run it live. The order
/// of components is that of the files.
///
/// # Errors
/// The first thing that stands in the way.
pub fn start(plan: &Plan, workshop: &mut dyn Workshop) -> Result<System, StartError> {
    start_part(plan, &Part::Whole, workshop).map(|assembled| assembled.system)
}

/// A part of a plan, ready to be attached to its buses and to run.
pub struct Assembled {
    /// The components, joined.
    pub system: System,
    /// What joins them to the rest of the plan, over buses.
    pub network: Network,
}

/// Builds a part of a plan's system, and what joins it to the rest over a bus.
///
/// # Errors
/// The first thing that stands in the way.
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
            building.system.slave(&component.name, master)?;
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
        building.network.set_sending(topic, sending);
    }
    for wire in &plan.wires {
        building.wire(wire)?;
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
        if let Some(broker) = self.plan.broker_of(&component.name) {
            self.network.put_on(id, broker);
        }
        for (name, value) in &component.properties.0 {
            let set = self.system.set_property(id, name, &value.datum());
            set.map_err(|source| StartError::Property {
                component: component.name.clone(),
                source,
            })?;
        }
        Ok(())
    }

    /// Joins the ports that are on a topic by themselves.
    fn topics(&mut self, component: &asmotion_plan::Component) -> Result<(), StartError> {
        for port in &component.outputs {
            if let Some(topic) = &port.topic
                && self.has(&component.name, |declared| {
                    declared.output(&port.name).is_some()
                })
            {
                self.system
                    .publish(&format!("{}.{}", component.name, port.name), topic)?;
            }
        }
        for port in &component.inputs {
            if let Some(topic) = &port.topic
                && self.has(&component.name, |declared| {
                    declared.input(&port.name).is_some()
                })
            {
                let end = format!("{}.{}", component.name, port.name);
                self.system
                    .subscribe(topic, &end, Policy::circular(SUBSCRIPTION_SIZE))?;
            }
        }
        Ok(())
    }

    /// Offers the services of a component to those outside of this part.
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
                    self.network.offer_at(&self.system, &end, &name, broker)?;
                }
            }
        }
        Ok(())
    }

    /// Whether a component really has something; what it does not use it need not declare.
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
                queue::from(&mut self.system, queue, to, joint, &policy)?;
            }
            (Terminal::Port(from), Terminal::Topic(topic)) if self.part.has(&from.component) => {
                self.system.publish(&from.to_string(), topic)?;
            }
            (Terminal::Topic(topic), Terminal::Port(to)) if self.part.has(&to.component) => {
                self.system.subscribe(topic, &to.to_string(), policy)?;
            }
            // the others are of another part; the checker refuses those that join no component
            (_, Terminal::Topic(_) | Terminal::Mqueue(_))
            | (Terminal::Topic(_) | Terminal::Mqueue(_), Terminal::Port(_)) => {}
        }
        Ok(())
    }

    /// Connects two ports, of which one or both may be of another part.
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

    fn wire(&mut self, wire: &asmotion_plan::Wire) -> Result<(), StartError> {
        let reference = &wire.reference;
        if !self.part.has(&reference.component) {
            return Ok(());
        }
        if !self.has(&reference.component, |declared| {
            declared.reference(&reference.name).is_some()
        }) {
            return Ok(());
        }
        if matches!(wire.binding, Transport::Ros | Transport::Http) {
            return Err(StartError::Binding {
                reference: reference.to_string(),
                binding: wire.binding,
            });
        }
        let how = how(wire);
        let broker = self.plan.broker_of_wire(wire);
        let caller = reference.to_string();
        for service in &wire.services {
            let provider = service.to_string();
            if stays_here(wire, service, self.part) {
                self.system.wire(&caller, &provider, how)?
            } else {
                let system = &mut self.system;
                self.network
                    .reach_over(system, &caller, &provider, how, broker)?;
            }
        }
        Ok(())
    }
}

/// The attempts and the patience of a wire.
pub(crate) fn how(wire: &asmotion_plan::Wire) -> Wire {
    Wire {
        timeout: Duration::from_millis(wire.timeout_ms),
        retries: u32::try_from(wire.retry.attempts).unwrap_or(u32::MAX),
        backoff: Duration::from_millis(wire.retry.backoff_ms),
        cancel_on_timeout: wire.cancel == model::Cancel::OnTimeout,
        one_way: wire.oneway,
    }
}

/// Whether a service is called without a bus by a component of this part.
pub(crate) fn stays_here(
    wire: &asmotion_plan::Wire,
    service: &asmotion_plan::End,
    part: &Part,
) -> bool {
    let abroad = part.takes_the_bus_inside() || (wire.goes_abroad() && !part.is_alone());
    part.has(&service.component) && !abroad
}

/// Stands in for a component that could not be made, until that is reported.
struct Nothing;

impl Component for Nothing {
    fn update(
        &mut self,
        _: &mut asmotion_component::Cycle<'_>,
    ) -> Result<(), asmotion_component::Fault> {
        Ok(())
    }
}

/// Makes a component of this build.
fn of_build(constructor: asmotion_composite::Constructor) -> Make {
    Box::new(move |interface: &mut Interface| Ok(constructor(interface)))
}
