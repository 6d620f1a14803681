//! What an executor brings, and what it needs no more than that for.

use std::sync::{Arc, mpsc};
use std::time::Duration;

use asmotion_component::{Declaration, LifeCycleError, State, Transition, suggestion_among};
use asmotion_datum::Sample;
use asmotion_port::{AnySender, ConnectionId, OutputLink, Time};

use super::asked::Asked;
use crate::build_error::BuildError;
use crate::connections::ConnectionTable;
use crate::descriptor::ComponentDescriptor;
use crate::effects::Effects;
use crate::end::{ComponentEnd, EndTable, find};
use crate::event::Event;
use crate::handle::RunHandle;
use crate::injection::{InjectionPorts, InjectionTarget};
use crate::run_error::RunError;
use crate::unit::ComponentUnit;

/// Looks at each event, and says whether it is the one waited for.
pub(crate) type Watch<'a> = &'a mut dyn FnMut(Time, &Event<'_>) -> bool;

/// Something to be done to a component between two of its cycles.
pub(crate) type Act = Box<dyn FnOnce(&mut ComponentUnit, Time, &mut dyn Effects) + Send>;

/// Drives the components of a system.
pub(crate) trait Executor {
    /// The present time.
    fn clock(&self) -> Time;

    /// What other threads see of the components, in order of addition.
    fn descriptors(&self) -> &[ComponentDescriptor];

    /// What joins their ports.
    fn connections(&mut self) -> (&mut ConnectionTable, &[ComponentDescriptor]);

    /// The connections into inputs and topics from outside.
    fn injections(&self) -> &InjectionPorts;

    /// The system, for readers and writers on threads of their own.
    fn handle(&self) -> Arc<dyn RunHandle>;

    /// Puts a sample into its target when its time has come.
    fn plan(&mut self, at: Time, target: InjectionTarget, sample: Arc<dyn Sample>);

    /// Lets time pass, at the longest until then, or until what is watched for has happened. Says whether it has.
    fn advance(&mut self, until: Time, watch: Option<Watch<'_>>) -> bool;

    /// Asks for a cycle of a component.
    fn call(&mut self, component: usize);

    /// How long to wait for a component whose cycle is under way.
    fn patience(&self) -> Duration;

    /// How long to wait for one only to look at it.
    fn glance(&self) -> Duration;

    /// Has something done to a component between two of its cycles, and does not wait for it.
    fn post(&mut self, component: usize, act: Act);

    /// Has something done to a component between two of its cycles, and waits so long for the answer.
    fn ask<R: Send + 'static>(
        &mut self,
        component: usize,
        patience: Duration,
        act: impl FnOnce(&mut ComponentUnit, Time, &mut dyn Effects) -> R + Send + 'static,
    ) -> Option<R> {
        let (answer, answered) = mpsc::channel();
        let act: Act = Box::new(move |unit, now, effects| {
            // A caller that has lost patience does not read it.
            let _ = answer.send(act(unit, now, effects));
        });
        self.post(component, act);
        match patience {
            Duration::MAX => answered.recv().ok(),
            patience => answered.recv_timeout(patience).ok(),
        }
    }

    /// The same, to be answered when it is done.
    fn begin(
        &mut self,
        component: usize,
        act: impl FnOnce(&mut ComponentUnit, Time, &mut dyn Effects) -> Result<(), RunError>
        + Send
        + 'static,
    ) -> Asked {
        let (answer, answered) = mpsc::channel();
        let asked = Asked::of(&self.descriptors()[component].name, answered);
        let act: Act = Box::new(move |unit, now, effects| {
            // The caller need not read it.
            let _ = answer.send(act(unit, now, effects));
        });
        self.post(component, act);
        asked
    }

    /// Takes a component through a transition.
    fn take_through(
        &mut self,
        component: usize,
        transition: Transition,
        patience: Duration,
    ) -> Result<(), LifeCycleError> {
        let descriptor = &self.descriptors()[component];
        let name = Arc::clone(&descriptor.name);
        descriptor.allow_interrupt(transition);
        let taken = self.ask(component, patience, move |unit, now, effects| {
            unit.transition(transition, now, effects)
        });
        taken.unwrap_or_else(|| {
            Err(LifeCycleError::Busy {
                component: name.to_string(),
                transition,
            })
        })
    }

    /// Configures everything, one after the other, then starts what runs on start-up. What fails is in the component's
    /// state, and told to the observers.
    fn start_up(&mut self) {
        for component in 0..self.descriptors().len() {
            if self.descriptors()[component].configure_on_startup {
                // However long it takes: maps are loaded here.
                let _ = self.take_through(component, Transition::Configure, Duration::MAX);
            }
        }
        for component in 0..self.descriptors().len() {
            let descriptor = &self.descriptors()[component];
            if descriptor.run_on_startup && descriptor.status.state() == State::Stopped {
                let patience = self.patience();
                let _ = self.take_through(component, Transition::Start, patience);
            }
        }
    }

    /// Stops what runs, last things first. Names what did not stop in time.
    fn stop_all(&mut self) -> Vec<String> {
        let mut late = Vec::new();
        for component in (0..self.descriptors().len()).rev() {
            if !self.descriptors()[component].status.state().is_running() {
                continue;
            }
            let patience = self.patience();
            let stopped = self.take_through(component, Transition::Stop, patience);
            if matches!(stopped, Err(LifeCycleError::Busy { .. })) {
                late.push(self.descriptors()[component].name.to_string());
            }
        }
        late
    }

    /// A component by name.
    fn descriptor(&self, component: &str) -> Option<&ComponentDescriptor> {
        self.descriptors()
            .iter()
            .find(|descriptor| *descriptor.name == *component)
    }

    /// A component's place by name.
    fn place_of(&self, component: &str) -> Result<usize, RunError> {
        let found =
            (self.descriptors().iter()).position(|descriptor| *descriptor.name == *component);
        found.ok_or_else(|| RunError::Unknown {
            what: "component",
            name: component.to_owned(),
            nearest: suggestion_among(
                component,
                self.descriptors()
                    .iter()
                    .map(|descriptor| &*descriptor.name),
            ),
        })
    }

    /// A port or service by name.
    fn end(
        &self,
        path: &str,
        table: fn(&Declaration) -> EndTable<'_>,
    ) -> Result<ComponentEnd, BuildError> {
        let descriptors = self.descriptors().iter();
        find(
            descriptors.map(|descriptor| (&*descriptor.name, &descriptor.declaration)),
            path,
            table,
        )
    }
}

/// An output gets a connection; and its reader what was last written, if the policy says so.
pub(super) fn joining(
    (output, connection): (usize, ConnectionId),
    sender: Box<dyn AnySender>,
    link: OutputLink,
    init: bool,
) -> Act {
    Box::new(move |unit, _, effects| {
        let output = &mut unit.body.outputs[output];
        output.join(sender, link);
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
