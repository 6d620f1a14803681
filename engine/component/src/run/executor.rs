//! What an executor brings, and what it needs no more than that for.

use std::sync::{Arc, mpsc};
use std::time::Duration;

use asmotion_datum::Sample;

use super::{Asked, Beyond, RunError, Watch};
use crate::declaration::Declaration;
use crate::door::{Doors, Place};
use crate::face::Face;
use crate::outside::Outside;
use crate::property::suggestion_among;
use crate::system::{End, Joints, Table, find};
use crate::unit::Unit;
use crate::{BuildError, LifeCycleError, State, Time, Transition};

/// Something to be done to a component between two of its cycles.
pub(crate) type Act = Box<dyn FnOnce(&mut Unit, Time, &mut dyn Outside) + Send>;

/// Drives the components of a system.
pub(crate) trait Executor {
    /// The present time.
    fn clock(&self) -> Time;

    /// What is known of the components, in order of addition.
    fn faces(&self) -> &[Face];

    /// What joins their ports.
    fn joints(&mut self) -> (&mut Joints, &[Face]);

    /// The ways in for those outside.
    fn doors(&self) -> &Doors;

    /// The system, for those who write and read by themselves.
    fn beyond(&self) -> Arc<dyn Beyond>;

    /// Gives a sample to its place when its time has come.
    fn plan(&mut self, at: Time, place: Place, sample: Arc<dyn Sample>);

    /// Lets time pass, at the longest until then, or until what is watched for has happened. Says whether it has.
    fn advance(&mut self, until: Time, watch: Option<Watch<'_>>) -> bool;

    /// Asks for a cycle of a component.
    fn call(&mut self, component: usize);

    /// How long to wait for a component whose cycle is under way.
    fn patience(&self) -> Duration;

    /// How long to wait for one only to look at it.
    fn glance(&self) -> Duration;

    /// Has something done to a component between two of its cycles; nobody waits for it.
    fn post(&mut self, component: usize, act: Act);

    /// Has something done to a component between two of its cycles, and waits so long for the answer.
    fn ask<R: Send + 'static>(
        &mut self,
        component: usize,
        patience: Duration,
        act: impl FnOnce(&mut Unit, Time, &mut dyn Outside) -> R + Send + 'static,
    ) -> Option<R> {
        let (answer, answered) = mpsc::channel();
        let act: Act = Box::new(move |unit, now, outside| {
            // Whoever has lost patience does not read it.
            let _ = answer.send(act(unit, now, outside));
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
        act: impl FnOnce(&mut Unit, Time, &mut dyn Outside) -> Result<(), RunError> + Send + 'static,
    ) -> Asked {
        let (answer, answered) = mpsc::channel();
        let asked = Asked::of(&self.faces()[component].name, answered);
        let act: Act = Box::new(move |unit, now, outside| {
            // Whoever asked need not read it.
            let _ = answer.send(act(unit, now, outside));
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
        let face = &self.faces()[component];
        let name = Arc::clone(&face.name);
        face.allow_interrupt(transition);
        let taken = self.ask(component, patience, move |unit, now, outside| {
            unit.transition(transition, now, outside)
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
        for component in 0..self.faces().len() {
            if self.faces()[component].configure_on_startup {
                // However long it takes: maps are loaded here.
                let _ = self.take_through(component, Transition::Configure, Duration::MAX);
            }
        }
        for component in 0..self.faces().len() {
            let face = &self.faces()[component];
            if face.run_on_startup && face.status.state() == State::Stopped {
                let patience = self.patience();
                let _ = self.take_through(component, Transition::Start, patience);
            }
        }
    }

    /// Stops what runs, last things first. Names what did not stop in time.
    fn stop_all(&mut self) -> Vec<String> {
        let mut late = Vec::new();
        for component in (0..self.faces().len()).rev() {
            if !self.faces()[component].status.state().is_running() {
                continue;
            }
            let patience = self.patience();
            let stopped = self.take_through(component, Transition::Stop, patience);
            if matches!(stopped, Err(LifeCycleError::Busy { .. })) {
                late.push(self.faces()[component].name.to_string());
            }
        }
        late
    }

    /// A component by name.
    fn face(&self, component: &str) -> Option<&Face> {
        self.faces().iter().find(|face| *face.name == *component)
    }

    /// A component's place by name.
    fn place_of(&self, component: &str) -> Result<usize, RunError> {
        let found = (self.faces().iter()).position(|face| *face.name == *component);
        found.ok_or_else(|| RunError::Unknown {
            what: "component",
            name: component.to_owned(),
            nearest: suggestion_among(component, self.faces().iter().map(|face| &*face.name)),
        })
    }

    /// A port or service by name.
    fn end(&self, path: &str, table: fn(&Declaration) -> Table<'_>) -> Result<End, BuildError> {
        let faces = self.faces().iter();
        find(
            faces.map(|face| (&*face.name, &face.declaration)),
            path,
            table,
        )
    }
}
