//! The builder of a system: components, properties, connections, topics, wires. It reads no file.

mod attach;
mod join;

use std::collections::BTreeMap;
use std::sync::Arc;

use asmotion_component::{
    Activity, Component, Declaration, Interface, PropertyError, PropertyProblem, State,
};
use asmotion_datum::Datum;
use asmotion_port::Notifier;

use crate::adapter::Adapter;
use crate::build_error::BuildError;
use crate::component_body::ComponentBody;
use crate::component_end::outputs;
use crate::component_unit::ComponentUnit;
use crate::connections::ConnectionTable;
use crate::descriptor::ComponentDescriptor;
use crate::event::Observer;
use crate::peers::PeerTable;
use crate::stream::{SinkStream, SourceStream};
use crate::topic::SystemTopic;

pub(crate) use join::operation_indices;

/// The builder of a system: adds components, sets properties, connects ports, and starts an executor.
///
/// ```
/// use asmotion_component::{Activity, Component, Cycle, Fault, Out, Span};
/// use asmotion_runtime::{BuildError, Run, System};
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
/// # Ok::<(), BuildError>(())
/// ```
///
/// (The first cycle is at zero, so a second has 101 cycles of 10 ms.)
#[derive(Default)]
pub struct System {
    pub(crate) units: Vec<ComponentUnit>,
    /// Position of each component by its name.
    positions: BTreeMap<Arc<str>, usize>,
    /// Names of components outside the system, by position; the others have the same name outside.
    pub(crate) external_names: BTreeMap<usize, Arc<str>>,
    pub(crate) observers: Vec<Box<dyn Observer>>,
    pub(crate) topics: Vec<SystemTopic>,
    /// Position of each topic by its name.
    pub(crate) topic_positions: BTreeMap<String, usize>,
    /// Adapters, not the system itself, connect publishers and subscribers.
    pub(crate) topics_outside: bool,
    pub(crate) adapters: Vec<Box<dyn Adapter>>,
    /// Wakes the thread that calls the adapters.
    pub(crate) notifier: Arc<Notifier>,
    pub(crate) connections: ConnectionTable,
    /// The statuses of the components.
    pub(crate) peers: PeerTable,
    /// The declaration of the component added last, which the next one shares if it declares the same.
    newest_declaration: Option<Arc<Declaration>>,
    /// Upkeeps of sinks.
    pub(crate) sinks: Vec<SinkStream>,
    /// Sources and the inputs that they feed.
    pub(crate) streams: Vec<SourceStream>,
}

/// Refers to a component of the system under construction.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ComponentId(pub(crate) usize);

impl ComponentId {
    /// Position of the component in the system, in order of addition from 0.
    pub fn position(self) -> usize {
        self.0
    }
}

impl System {
    /// Creates a system without components.
    pub fn new() -> Self {
        Self::default()
    }

    /// An alias of [`System::new`].
    pub fn builder() -> Self {
        Self::default()
    }

    /// Adds a component with a name, an activity and a constructor.
    ///
    /// The order of additions determines the order of configuration and of cycles that are due at the same instant.
    ///
    /// # Errors
    /// [`BuildError::Name`] if the name is empty or taken, [`BuildError::Declaration`] with the first contradiction in
    /// what the component declares.
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
        let mut body = ComponentBody::new(interface, index);
        // components of one kind often follow each other
        match &self.newest_declaration {
            Some(known) if **known == *body.declaration => body.declaration = Arc::clone(known),
            Some(_) | None => self.newest_declaration = Some(Arc::clone(&body.declaration)),
        }
        let name = Arc::from(name);
        self.positions.insert(Arc::clone(&name), index);
        let mut unit = ComponentUnit::new(name, index, activity, component, body);
        unit.join(&self.peers);
        self.units.push(unit);
        Ok(ComponentId(index))
    }

    /// The component with this name.
    pub fn id(&self, name: &str) -> Option<ComponentId> {
        self.positions.get(name).copied().map(ComponentId)
    }

    /// The declaration of a component.
    pub fn declaration(&self, component: ComponentId) -> Option<&Declaration> {
        let unit = self.units.get(component.0);
        unit.map(|unit| &*unit.body.declaration)
    }

    /// Sets a property after checking the value against its type, range and choices.
    ///
    /// # Errors
    /// There is no such component or property, or the value is refused; see [`PropertyProblem`].
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
        // takes effect when the component is configured
        let values = [(property.to_owned(), value.clone())];
        unit.body.prepare(&unit.name, &values)
    }

    /// Sets the sample that is written to an output (`component.port`) after the component's last cycle, in place of the
    /// one that the component declares. Omitted fields have their initial values.
    ///
    /// # Errors
    /// [`BuildError::Unknown`] or [`BuildError::Direction`] if there is no such output, [`BuildError::SafeSample`] if the
    /// sample does not have its type.
    pub fn set_safe_sample(&mut self, output: &str, sample: &Datum) -> Result<(), BuildError> {
        let end = self.end(output, outputs)?;
        let body = &mut self.units[end.unit].body;
        let set = body.outputs[end.index].set_safe(sample);
        set.map_err(|source| BuildError::SafeSample {
            output: end.name,
            source,
        })?;
        // other components may share it
        let declaration = Arc::make_mut(&mut body.declaration);
        declaration.outputs[end.index].safe = Some(sample.clone());
        Ok(())
    }

    /// Adds an observer, which receives all events from the first configuration on.
    pub fn observe(&mut self, observer: impl Observer + 'static) {
        self.observers.push(Box::new(observer));
    }

    /// The state of a component: [`State::Init`] until the system runs.
    pub fn state(&self, component: ComponentId) -> Option<State> {
        self.units.get(component.0).map(ComponentUnit::state)
    }

    /// Prepares the units for an executor. Returns the descriptors that other threads see.
    pub(crate) fn begin_run(&mut self) -> Vec<ComponentDescriptor> {
        self.units.iter_mut().for_each(ComponentUnit::begin_run);
        let threads: Vec<_> = (0..self.units.len())
            .map(|unit| self.thread(unit))
            .collect();
        let units = self.units.iter().zip(threads);
        units
            .map(|(unit, thread)| unit.descriptor(thread))
            .collect()
    }
}
