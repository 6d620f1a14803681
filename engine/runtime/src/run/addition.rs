//! Addition of components to a running system.
//!
//! A new component is constructed, connected, configured and started before any other component is changed, so that a
//! failure changes nothing. Its cycles begin when all changes have been made. A live run waits for its hooks up to the grace
//! period: they run in the component's own thread, so that one which hangs neither holds up the system nor ends with it.

use std::fmt;
use std::sync::Arc;

use asmotion_component::{Activity, Component, Interface, LifeCycleError, State, Transition};
use asmotion_datum::Datum;
use asmotion_port::{Policy, Time};

use super::change::{ChangeError, ChangePlan, UndoStep};
use super::executor::Executor;
use super::replacement::Construct;
use crate::build_error::BuildError;
use crate::component_body::ComponentBody;
use crate::component_end::{ComponentEnd, inputs, outputs};
use crate::component_unit::ComponentUnit;
use crate::connections::ConnectionTable;
use crate::effects::{Effects, NoEffects};
use crate::event::{Event, OwnedEvent};
use crate::injection::{InjectionPort, WAITING};
use crate::outer_end::OuterEnd;

/// Kind of the report that a component was added to a running system; its content is the description of the component.
pub const ADDITION_REPORT: &str = "added";

/// A component that is added to a running system: its constructor and its settings.
#[derive(Clone)]
pub struct ComponentAddition {
    description: Arc<str>,
    construct: Arc<Construct>,
    activity: Activity,
    properties: Vec<(String, Datum)>,
    /// Outputs and their safe samples.
    safe_samples: Vec<(String, Datum)>,
    /// Outputs and the topics that they publish on.
    published: Vec<(String, String)>,
    /// Topics, the inputs that subscribe to them, and the policies of their connections.
    subscribed: Vec<(String, String, Policy)>,
    /// Ends that are joined to the outside.
    joined: Vec<OuterEnd>,
}

impl ComponentAddition {
    /// Describes the component by the rest of the sentence "it runs …". The constructor may be called several times.
    pub fn new(
        description: impl Into<Arc<str>>,
        activity: Activity,
        construct: impl Fn(&mut Interface) -> Result<Box<dyn Component>, String> + Send + Sync + 'static,
    ) -> Self {
        Self {
            description: description.into(),
            construct: Arc::new(construct),
            activity,
            properties: Vec::new(),
            safe_samples: Vec::new(),
            published: Vec::new(),
            subscribed: Vec::new(),
            joined: Vec::new(),
        }
    }

    /// Sets a property; the last of several values counts.
    #[must_use]
    pub fn property(mut self, name: impl Into<String>, value: Datum) -> Self {
        self.properties.push((name.into(), value));
        self
    }

    /// Sets the sample that is written to an output after the last cycle, in place of the one that the component declares.
    #[must_use]
    pub fn safe_sample(mut self, output: impl Into<String>, sample: Datum) -> Self {
        self.safe_samples.push((output.into(), sample));
        self
    }

    /// Publishes an output on a topic.
    #[must_use]
    pub fn publish(mut self, output: impl Into<String>, topic: impl Into<String>) -> Self {
        self.published.push((output.into(), topic.into()));
        self
    }

    /// Subscribes an input to a topic, with this policy for each of its publishers.
    #[must_use]
    pub fn subscribe(
        mut self,
        topic: impl Into<String>,
        input: impl Into<String>,
        policy: Policy,
    ) -> Self {
        self.subscribed.push((topic.into(), input.into(), policy));
        self
    }

    /// Joins an end of the component to the outside.
    #[must_use]
    pub fn joined(mut self, end: OuterEnd) -> Self {
        self.joined.push(end);
        self
    }

    /// Constructs the unit at a position of the system.
    fn make(&self, name: &str, position: usize) -> Result<ComponentUnit, ChangeError> {
        let mut interface = Interface::new();
        let component = (self.construct)(&mut interface);
        let component = component.map_err(|reason| refused(name, reason))?;
        if let Some(problem) = interface.problems().first() {
            let (component, source) = (name.to_owned(), problem.clone());
            return Err(BuildError::Declaration { component, source }.into());
        }
        let body = ComponentBody::new(interface, position);
        let activity = self.activity.clone();
        let mut unit = ComponentUnit::new(Arc::from(name), position, activity, component, body);
        for value in &self.properties {
            let values = std::slice::from_ref(value);
            unit.body.prepare(name, values).map_err(BuildError::from)?;
        }
        Ok(unit)
    }
}

impl fmt::Display for ComponentAddition {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.description)
    }
}

impl fmt::Debug for ComponentAddition {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_tuple("ComponentAddition")
            .field(&self.description)
            .finish()
    }
}

/// Two additions are equal if they have the same constructor.
impl PartialEq for ComponentAddition {
    fn eq(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.construct, &other.construct)
    }
}

/// A new component that no other component uses yet.
pub(super) struct StagedComponent {
    pub unit: ComponentUnit,
    /// Connections from outside into its inputs.
    injections: Vec<InjectionPort>,
    /// Connections from outside into the topics to which it subscribes.
    pub topic_injections: Vec<(String, InjectionPort)>,
    events: HeldEvents,
}

/// Keeps the events of a new component until its addition is certain; other effects have no receiver yet.
struct HeldEvents(Vec<(Time, OwnedEvent)>);

impl Effects for HeldEvents {
    fn emit(&mut self, at: Time, event: &Event<'_>) {
        self.0.push((at, OwnedEvent::of(event)));
    }

    fn wants_report(&self, _: &str) -> bool {
        true
    }

    fn trigger(&mut self, _: usize) {}

    fn wake_at(&mut self, _: usize, _: Time) {}

    fn escalate(&mut self, _: usize) {}

    /// Cannot be called: a component writes only in its cycles.
    fn next_order(&mut self) -> u64 {
        0
    }
}

impl<E: Executor> ChangePlan<'_, E> {
    /// Plans a new component.
    pub(super) fn add(
        &mut self,
        component: &str,
        by: &ComponentAddition,
    ) -> Result<(), ChangeError> {
        if component.is_empty() || self.run.descriptor(component).is_some() {
            let name = component.to_owned();
            return Err(BuildError::Name { name }.into());
        }
        let position = self.run.descriptors().len();
        let mut unit = by.make(component, position)?;
        unit.body.work_place = self.run.prepare(position);
        unit.begin_run();
        let (connections, _) = self.run.connections();
        let injections = injections(&mut unit, connections);
        let description = Datum::text(&*by.description);
        let mut events = HeldEvents(Vec::new());
        let event = Event::Report {
            component,
            kind: ADDITION_REPORT,
            data: &description,
        };
        events.emit(self.run.clock(), &event);
        self.run.descriptors_mut().push(unit.descriptor(position));
        self.undo_steps.push(UndoStep::Unadd);
        self.additions.push(StagedComponent {
            unit,
            injections,
            topic_injections: Vec::new(),
            events,
        });
        for (output, sample) in &by.safe_samples {
            let output = self.run.end(&format!("{component}.{output}"), outputs)?;
            self.set_safe(output, sample)?;
        }
        for (output, topic) in &by.published {
            let output = self.run.end(&format!("{component}.{output}"), outputs)?;
            self.publish(output, topic)?;
        }
        for (topic, input, policy) in &by.subscribed {
            let input = self.run.end(&format!("{component}.{input}"), inputs)?;
            self.subscribe(topic, input, policy)?;
        }
        by.joined.iter().try_for_each(|end| self.join(end))
    }

    /// The new component at this position; `None` if the component there runs already.
    pub(super) fn staged(&mut self, component: usize) -> Option<&mut StagedComponent> {
        let mut additions = self.additions.iter_mut();
        additions.find(|it| it.unit.index == component)
    }

    fn set_safe(&mut self, output: ComponentEnd, sample: &Datum) -> Result<(), BuildError> {
        let Some(staged) = self.staged(output.unit) else {
            return Ok(());
        };
        let set = staged.unit.body.outputs[output.index].set_safe(sample);
        set.map_err(|source| BuildError::SafeSample {
            output: output.name,
            source,
        })?;
        let declaration = Arc::make_mut(&mut staged.unit.body.declaration);
        declaration.outputs[output.index].safe = Some(sample.clone());
        let declaration = Arc::clone(&staged.unit.body.declaration);
        self.run.descriptors_mut()[output.unit].declaration = declaration;
        Ok(())
    }

    /// Applies the planned steps to the new components, which no other component sees yet, then configures them in order
    /// and starts those with `run_on_startup`.
    pub(super) fn prepare_additions(&mut self) -> Result<(), ChangeError> {
        let now = self.run.clock();
        for staged in &mut self.additions {
            let index = staged.unit.index;
            for steps in [&mut self.attach_steps, &mut self.update_steps] {
                for (_, act) in steps.extract_if(.., |(unit, _)| *unit == index) {
                    act(&mut staged.unit, now, &mut staged.events);
                }
            }
            for step in self
                .detach_steps
                .extract_if(.., |step| step.reader == index)
            {
                (step.act)(&mut staged.unit, now, &mut staged.events);
            }
        }
        for index in 0..self.additions.len() {
            if self.additions[index].unit.activity.configure_on_startup {
                self.transition_addition(index, Transition::Configure)?;
            }
        }
        for index in 0..self.additions.len() {
            let unit = &self.additions[index].unit;
            if unit.activity.run_on_startup && unit.state() == State::Stopped {
                self.transition_addition(index, Transition::Start)?;
            }
        }
        Ok(())
    }

    /// Carries out a transition of a new component. One that takes too long is cleaned up as soon as it has ended.
    fn transition_addition(
        &mut self,
        index: usize,
        transition: Transition,
    ) -> Result<(), ChangeError> {
        let now = self.run.clock();
        let mut staged = self.additions.remove(index);
        let (position, name) = (staged.unit.index, Arc::clone(&staged.unit.name));
        let work = move || {
            let made = staged.transition(transition, now);
            (staged, made)
        };
        let late = move |(mut staged, _): (StagedComponent, _)| {
            staged.unit.remove(now, &mut NoEffects);
        };
        match self.run.run_for_new((position, &name), work, late) {
            Some((staged, made)) => {
                self.additions.insert(index, staged);
                made
            }
            None => {
                let limit = self.run.change_timeout();
                let reason = format!("its `{transition}` takes longer than {limit:?}");
                Err(refused(&name, reason))
            }
        }
    }

    /// Stops and cleans up the new components, because a change is impossible.
    pub(super) fn abandon_additions(&mut self) {
        let now = self.run.clock();
        while let Some(mut staged) = self.additions.pop() {
            let (position, name) = (staged.unit.index, Arc::clone(&staged.unit.name));
            let work = move || staged.unit.remove(now, &mut NoEffects);
            self.run.run_for_new((position, &name), work, |()| {});
        }
        self.run.abandon_new();
    }

    /// Lets the executor take over the new components.
    pub(super) fn adopt_additions(&mut self) {
        for staged in std::mem::take(&mut self.additions) {
            let StagedComponent {
                unit,
                injections,
                topic_injections,
                events,
            } = staged;
            self.run.injections_mut().add(injections, topic_injections);
            for (at, event) in &events.0 {
                self.run.emit(*at, &event.borrow());
            }
            self.run.adopt(unit);
        }
    }
}

impl StagedComponent {
    fn transition(&mut self, transition: Transition, now: Time) -> Result<(), ChangeError> {
        let made = self.unit.transition(transition, now, &mut self.events);
        made.map_err(|error| {
            let reason = match error {
                LifeCycleError::Failed { fault, .. } => fault.to_string(),
                LifeCycleError::Refused { .. }
                | LifeCycleError::Unknown { .. }
                | LifeCycleError::Busy { .. } => error.to_string(),
            };
            refused(&self.unit.name, reason)
        })
    }
}

/// Opens connections from outside into all inputs of a new component.
fn injections(unit: &mut ComponentUnit, connections: &mut ConnectionTable) -> Vec<InjectionPort> {
    let policy = Policy::buffer(WAITING);
    let inputs = 0..unit.body.inputs.len();
    let ports = inputs.filter_map(|index| {
        InjectionPort::open_undeclared(unit, index, &policy, connections.next_id())
    });
    ports.collect()
}

fn refused(component: &str, reason: String) -> ChangeError {
    ChangeError::Addition {
        component: component.to_owned(),
        reason,
    }
}
