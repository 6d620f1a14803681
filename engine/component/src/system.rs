//! The builder of a system: components, properties, connections, topics, wires. It reads no file.

mod abroad;
mod ends;
mod error;
mod join;
mod joints;

use std::collections::BTreeMap;
use std::sync::Arc;

use asmotion_bus::{Bus, BusError, Sending};
use asmotion_datum::Datum;

pub use abroad::port_topic;
pub(crate) use abroad::{Abroad, Offered, address, is_on};
pub(crate) use ends::{End, Table, find, inputs, outputs, references, services};
pub use error::BuildError;
pub(crate) use join::fit;
pub(crate) use joints::{ConnectionId, Forgotten, Joints};

use crate::body::Body;
use crate::declaration::Declaration;
use crate::exchange::Exchange;
use crate::face::Face;
use crate::property::{PropertyError, PropertyProblem};
use crate::stream::Incoming;
use crate::unit::Unit;
use crate::{Activity, Component, Interface, Live, Observer, Policy, Simulation, State};

/// A system in the making.
///
/// ```
/// use asmotion_component::{Activity, Component, Cycle, Fault, Out, Run, Span, System};
///
/// asmotion_datum::message! {
///     /// A count.
///     pub struct Count = "example/Count" {
///         /// ticks
///         pub ticks: u32,
///     }
/// }
///
/// struct Ticker { ticks: Out<Count> }
///
/// impl Component for Ticker {
///     fn update(&mut self, cycle: &mut Cycle<'_>) -> Result<(), Fault> {
///         cycle.write(self.ticks, Count { ticks: 1 });
///         Ok(())
///     }
/// }
///
/// let mut system = System::new();
/// system.add("Ticker", Activity::periodic(10.ms()), |interface| {
///     Box::new(Ticker { ticks: interface.output("ticks", "one a cycle") })
/// })?;
/// system.publish("Ticker.ticks", "ticks")?;
/// let mut run = system.simulate();
/// run.run_for(1.s());
/// assert_eq!(run.cycles("Ticker"), 101);
/// # Ok::<(), component::BuildError>(())
/// ```
///
/// (The first cycle is at zero, so a second has 101 cycles of 10 ms.)
#[derive(Default)]
pub struct System {
    pub(crate) units: Vec<Unit>,
    pub(crate) observers: Vec<Box<dyn Observer>>,
    pub(crate) topics: Vec<Topic>,
    pub(crate) exchange: Option<Exchange>,
    pub(crate) joints: Joints,
    /// What is joined over a bus.
    abroad: Abroad,
    /// Inputs that sources lead to.
    pub(crate) streams: Vec<Incoming>,
}

/// A component of a system under construction.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ComponentId(pub(crate) usize);

/// A topic: who writes to it, who reads it.
pub(crate) struct Topic {
    pub name: String,
    pub publishers: Vec<End>,
    pub subscribers: Vec<(End, Policy)>,
    /// How it goes over a bus.
    pub sending: Sending,
}

impl Topic {
    /// As the components see it that are here.
    pub(crate) fn of(&self, is_here: impl Fn(usize) -> bool) -> Self {
        let publishers = self.publishers.iter();
        let subscribers = self.subscribers.iter();
        Self {
            name: self.name.clone(),
            publishers: publishers.filter(|it| is_here(it.unit)).cloned().collect(),
            subscribers: (subscribers.filter(|(it, _)| is_here(it.unit)))
                .cloned()
                .collect(),
            sending: self.sending,
        }
    }
}

impl System {
    /// A system without components.
    pub fn new() -> Self {
        Self::default()
    }

    /// The same as [`System::new`], for those who look for a builder.
    pub fn builder() -> Self {
        Self::default()
    }

    /// Adds a component: its name, what drives it, its constructor. The order of additions is the order of
    /// everything else: of configuring, of cycles due at one instant.
    pub fn add(
        &mut self,
        name: &str,
        activity: Activity,
        construct: impl FnOnce(&mut Interface) -> Box<dyn Component>,
    ) -> Result<ComponentId, BuildError> {
        if name.is_empty() || self.id(name).is_some() {
            return Err(BuildError::Name {
                name: name.to_owned(),
            });
        }
        let mut interface = Interface::new();
        let component = construct(&mut interface);
        if let Some(problem) = interface.problems().first() {
            return Err(BuildError::Declaration {
                component: name.to_owned(),
                source: problem.clone(),
            });
        }
        let index = self.units.len();
        let body = Body::new(interface, index);
        let unit = Unit::new(Arc::from(name), index, activity, component, body);
        self.units.push(unit);
        Ok(ComponentId(index))
    }

    /// A component by name.
    pub fn id(&self, name: &str) -> Option<ComponentId> {
        let found = self.units.iter().position(|unit| *unit.name == *name);
        found.map(ComponentId)
    }

    /// What a component declares.
    pub fn declaration(&self, component: ComponentId) -> Option<&Declaration> {
        let unit = self.units.get(component.0);
        unit.map(|unit| &unit.body.declaration)
    }

    /// Sets a property; the value is checked against its type, range and choices.
    pub fn set_property(
        &mut self,
        component: ComponentId,
        property: &str,
        value: &Datum,
    ) -> Result<(), PropertyError> {
        let Some(unit) = self.units.get_mut(component.0) else {
            return Err(PropertyError {
                component: format!("component {}", component.0),
                property: property.to_owned(),
                problem: Box::new(PropertyProblem::Unknown { nearest: None }),
            });
        };
        // Put in place when the component is configured.
        let values = [(property.to_owned(), value.clone())];
        unit.body.prepare(&unit.name, &values)
    }

    /// Adds an observer; it sees everything from the first configuring on.
    pub fn observe(&mut self, observer: impl Observer + 'static) {
        self.observers.push(Box::new(observer));
    }

    /// Joins the topics declared so far to those of a bus: what is published here goes out, what others publish
    /// comes in, to each subscriber by its own policy (see [`System::sending`] for how); and with them the ports,
    /// services and references that were declared to be reached over it. `incarnation` numbers the lives of this
    /// process, and no two processes share one: what carries it is our own, and does not come in again where it was
    /// handed over inside.
    pub fn attach(&mut self, bus: Arc<dyn Bus>, incarnation: u64) -> Result<(), BusError> {
        self.join_buses(vec![(None, bus)], incarnation)
    }

    /// The same with several buses by name: what is on one of them ([`System::put_on`]) is joined to that one, and
    /// what is on none stays inside.
    pub fn attach_each(
        &mut self,
        buses: BTreeMap<String, Arc<dyn Bus>>,
        incarnation: u64,
    ) -> Result<(), BusError> {
        let buses = buses.into_iter().map(|(name, bus)| (Some(name), bus));
        self.join_buses(buses.collect(), incarnation)
    }

    fn join_buses(
        &mut self,
        buses: Vec<(Option<String>, Arc<dyn Bus>)>,
        incarnation: u64,
    ) -> Result<(), BusError> {
        let abroad = std::mem::take(&mut self.abroad);
        let exchange = Exchange::new(
            &mut self.units,
            &self.topics,
            &mut self.joints,
            abroad,
            buses,
            incarnation,
        )?;
        self.exchange = Some(exchange);
        Ok(())
    }

    /// The state of a component: [`State::Init`], until the system runs.
    pub fn state(&self, component: ComponentId) -> Option<State> {
        self.units.get(component.0).map(Unit::state)
    }

    /// The system begins to run. What everybody may know of the components, and their place in their threads.
    pub(crate) fn take_up(&mut self) -> Vec<Face> {
        self.units.iter_mut().for_each(Unit::take_up);
        let threads: Vec<_> = (0..self.units.len())
            .map(|unit| self.thread(unit))
            .collect();
        let units = self.units.iter().zip(threads);
        units.map(|(unit, thread)| unit.face(thread)).collect()
    }

    /// Starts the system in simulated time: every component is configured, then those that run on start-up start,
    /// all at time zero. What fails is left out, and seen in its state and by the observers.
    pub fn simulate(self) -> Simulation {
        Simulation::new(self)
    }

    /// Starts the system in real time, a thread for each component: every component is configured, then those that
    /// run on start-up start. What fails is left out, and seen in its state and by the observers.
    pub fn live(self) -> Live {
        Live::new(self)
    }
}
