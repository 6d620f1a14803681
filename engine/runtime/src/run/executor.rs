//! The operations that each executor implements, and those built on them alone.

use std::sync::{Arc, mpsc};
use std::time::Duration;

use asmotion_component::{
    Declaration, LifeCycleError, State, Transition, WorkPlace, suggestion_among,
};
use asmotion_datum::Sample;
use asmotion_port::{AnySender, ConnectionId, OutputLink, Time};

use super::asked::Asked;
use super::stop_order::stop_order;
use crate::build_error::BuildError;
use crate::component_end::{ComponentEnd, EndTable, find};
use crate::component_unit::ComponentUnit;
use crate::connections::ConnectionTable;
use crate::descriptor::ComponentDescriptor;
use crate::effects::Effects;
use crate::event::{Event, ReportInterest};
use crate::handle::RunHandle;
use crate::injection::{InjectionPorts, InjectionTarget};
use crate::peers::PeerTable;
use crate::run_error::RunError;

/// Waits for an event.
pub(crate) struct Watch<'a> {
    /// The reports that `predicate` uses.
    pub reports: ReportInterest,
    /// Inspects each event and returns whether it is the awaited one.
    pub predicate: &'a mut dyn FnMut(Time, &Event<'_>) -> bool,
}

impl Watch<'_> {
    /// The same watch, for a part of its time.
    pub(crate) fn reborrow(&mut self) -> Watch<'_> {
        Watch {
            reports: self.reports,
            predicate: &mut *self.predicate,
        }
    }
}

/// A function to run on a component between two of its cycles.
pub(crate) type Act = Box<dyn FnOnce(&mut ComponentUnit, Time, &mut dyn Effects) + Send>;

/// Drives the components of a system.
pub(crate) trait Executor {
    /// Current time of the executor's clock.
    fn clock(&self) -> Time;

    /// The shared descriptors of the components, in order of addition. Positions of removed components are vacant.
    fn descriptors(&self) -> &[ComponentDescriptor];

    /// The components of the system by name.
    fn peers(&self) -> &PeerTable;

    /// The descriptors, for changes of the components and their wires.
    fn descriptors_mut(&mut self) -> &mut Vec<ComponentDescriptor>;

    /// The connections between the components' ports, and the descriptors.
    fn connections(&mut self) -> (&mut ConnectionTable, &[ComponentDescriptor]);

    /// The connections from outside into inputs and topics.
    fn injections(&self) -> &InjectionPorts;

    /// The connections from outside, for changes of the components.
    fn injections_mut(&mut self) -> &mut InjectionPorts;

    /// Makes room for a component at this position. Returns the executor of its background work.
    fn prepare(&mut self, component: usize) -> WorkPlace;

    /// Runs work for the new component at this position, with this name, in the thread that will run its cycles, and waits up to
    /// the [change timeout](Self::change_timeout) for the result. Returns `None` if it does not come in time: it goes to `late`
    /// then, in the same thread.
    fn run_for_new<R: Send + 'static>(
        &mut self,
        component: (usize, &str),
        work: impl FnOnce() -> R + Send + 'static,
        late: impl FnOnce(R) + Send + 'static,
    ) -> Option<R>;

    /// Ends the threads of the new components that have not been taken over.
    fn abandon_new(&mut self);

    /// Takes over a unit, whose position follows that of the last one, and begins its cycles if it runs.
    fn adopt(&mut self, unit: ComponentUnit);

    /// Drops the unit at this position after its current cycle and the functions submitted so far.
    fn vacate(&mut self, component: usize);

    /// Reports an event to the observers.
    fn emit(&mut self, at: Time, event: &Event<'_>);

    /// The system, for readers and writers on their own threads.
    fn handle(&self) -> Arc<dyn RunHandle>;

    /// Puts a sample into its target at this time.
    fn schedule_injection(&mut self, at: Time, target: InjectionTarget, sample: Arc<dyn Sample>);

    /// Lets time pass, at most until `until` or until an event satisfies `watch`. Returns whether one did.
    fn advance(&mut self, until: Time, watch: Option<Watch<'_>>) -> bool;

    /// Requests one cycle of a component.
    fn request_cycle(&mut self, component: usize);

    /// Longest wait for a component whose cycle is under way, if it is to change.
    fn change_timeout(&self) -> Duration;

    /// Longest wait for a component whose cycle is under way, if it is only to be inspected.
    fn inspect_timeout(&self) -> Duration;

    /// Returns whether components run in several threads.
    fn has_threads(&self) -> bool;

    /// Runs a function on a component between two of its cycles, without waiting for it.
    fn submit(&mut self, component: usize, act: Act);

    /// Runs a function on a component between two of its cycles, and waits up to `timeout` for the result. Returns
    /// `None` if it does not come in time.
    fn run_on<R: Send + 'static>(
        &mut self,
        component: usize,
        timeout: Duration,
        act: impl FnOnce(&mut ComponentUnit, Time, &mut dyn Effects) -> R + Send + 'static,
    ) -> Option<R> {
        let (answer, answered) = mpsc::channel();
        let act: Act = Box::new(move |unit, now, effects| {
            // fails if the caller's patience has ended
            let _ = answer.send(act(unit, now, effects));
        });
        self.submit(component, act);
        match timeout {
            Duration::MAX => answered.recv().ok(),
            patience => answered.recv_timeout(patience).ok(),
        }
    }

    /// Runs a function on a component between two of its cycles; the result is collected from the returned handle.
    fn begin_on(
        &mut self,
        component: usize,
        act: impl FnOnce(&mut ComponentUnit, Time, &mut dyn Effects) -> Result<(), RunError>
        + Send
        + 'static,
    ) -> Asked {
        let (answer, answered) = mpsc::channel();
        let asked = Asked::of(&self.descriptors()[component].name, answered);
        let act: Act = Box::new(move |unit, now, effects| {
            // fails if the caller has dropped the handle
            let _ = answer.send(act(unit, now, effects));
        });
        self.submit(component, act);
        asked
    }

    /// Makes a transition of a component and waits up to `timeout` for it.
    fn run_transition(
        &mut self,
        component: usize,
        transition: Transition,
        timeout: Duration,
    ) -> Result<(), LifeCycleError> {
        let descriptor = &self.descriptors()[component];
        let name = Arc::clone(&descriptor.name);
        descriptor.allow_interrupt(transition);
        let taken = self.run_on(component, timeout, move |unit, now, effects| {
            unit.transition(transition, now, effects)
        });
        taken.unwrap_or_else(|| {
            Err(LifeCycleError::Busy {
                component: name.to_string(),
                transition,
            })
        })
    }

    /// Configures all components in order, then starts those with `run_on_startup`. Failures show in a component's
    /// state and in events.
    fn start_up(&mut self) {
        for component in 0..self.descriptors().len() {
            if self.descriptors()[component].configure_on_startup {
                // waits without limit: components load maps here
                let _ = self.run_transition(component, Transition::Configure, Duration::MAX);
            }
        }
        for component in 0..self.descriptors().len() {
            let descriptor = &self.descriptors()[component];
            if descriptor.run_on_startup && descriptor.status.state() == State::Stopped {
                let patience = self.change_timeout();
                let _ = self.run_transition(component, Transition::Start, patience);
            }
        }
    }

    /// Stops all running components in their [order](stop_order). Returns the names of those that did not stop in time.
    fn stop_all(&mut self) -> Vec<String> {
        let mut late = Vec::new();
        let (connections, descriptors) = self.connections();
        for component in stop_order(connections, descriptors) {
            let patience = self.change_timeout();
            let stopped = self.run_transition(component, Transition::Stop, patience);
            if matches!(stopped, Err(LifeCycleError::Busy { .. })) {
                late.push(self.descriptors()[component].name.to_string());
            }
        }
        late
    }

    /// The descriptor of the component with this name.
    fn descriptor(&self, component: &str) -> Option<&ComponentDescriptor> {
        self.descriptors().get(self.position(component)?)
    }

    /// The position of the component with this name.
    fn position(&self, component: &str) -> Option<usize> {
        let descriptors = self.descriptors();
        let is_it = |descriptor: &ComponentDescriptor| {
            !descriptor.is_vacant() && *descriptor.name == *component
        };
        let known = self.peers().position(component);
        let known = known.filter(|known| descriptors.get(*known).is_some_and(is_it));
        // while components are exchanged, descriptors and peers can differ
        known.or_else(|| descriptors.iter().position(is_it))
    }

    /// The position of the component with this name.
    fn index_of(&self, component: &str) -> Result<usize, RunError> {
        let index = self.position(component);
        index.ok_or_else(|| RunError::Unknown {
            kind: "component",
            name: component.to_owned(),
            nearest: suggestion_among(
                component,
                self.descriptors()
                    .iter()
                    .map(|descriptor| &*descriptor.name)
                    .filter(|name| !name.is_empty()),
            ),
        })
    }

    /// The port, service or reference with this path.
    fn end(
        &self,
        path: &str,
        table: fn(&Declaration) -> EndTable<'_>,
    ) -> Result<ComponentEnd, BuildError> {
        let descriptors = self.descriptors().iter();
        find(
            descriptors.map(|descriptor| (&*descriptor.name, &*descriptor.declaration)),
            path,
            table,
        )
    }
}

/// Adds a connection to an output and, if the policy has `init`, sends the newest sample through it.
pub(super) fn connect_output(
    (output, connection): (usize, ConnectionId),
    sender: Box<dyn AnySender>,
    link: OutputLink,
    init: bool,
) -> Act {
    Box::new(move |unit, _, effects| {
        let output = &mut unit.body.outputs[output];
        output.connect(sender, link);
        if init {
            output.replay_last(connection, &mut |reader| effects.trigger(reader));
        }
    })
}

pub(super) fn busy(component: &str) -> RunError {
    RunError::Busy {
        component: component.to_owned(),
    }
}
