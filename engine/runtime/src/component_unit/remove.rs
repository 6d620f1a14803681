//! Removal of a component from a running system, and the vacant position that it leaves.

use std::sync::Arc;

use asmotion_component::{
    Activity, CannotFreeze, Component, Cycle, Fault, FrozenState, Interface, State, ThawError,
    Transition, guarded,
};
use asmotion_datum::Datum;
use asmotion_port::Time;

use super::ComponentUnit;
use crate::component_body::ComponentBody;
use crate::effects::Effects;
use crate::event::Event;

/// Kind of the report that a component was removed from a running system.
pub const REMOVAL_REPORT: &str = "removed";

/// The component of a vacant position.
struct Vacant;

impl Component for Vacant {
    fn update(&mut self, _: &mut Cycle<'_>) -> Result<(), Fault> {
        Ok(())
    }

    fn freeze(&self) -> Result<FrozenState, CannotFreeze> {
        FrozenState::of("asmotion::Vacant", 1, &())
    }

    fn thaw(&mut self, state: &FrozenState) -> Result<(), ThawError> {
        state.read("asmotion::Vacant", 1)
    }
}

impl ComponentUnit {
    /// The unit of a vacant position: it has no name and no ends, and its state permits no transition.
    pub(crate) fn vacant(index: usize) -> Self {
        let body = ComponentBody::new(Interface::new(), index);
        Self::new(
            Arc::from(""),
            index,
            Activity::manual(),
            Box::new(Vacant),
            body,
        )
    }

    /// Stops the component with a last cycle and cleans it up, whatever its state, and reports that it is removed.
    /// Failures show in events.
    pub(crate) fn remove(&mut self, now: Time, effects: &mut dyn Effects) {
        if self.state.is_running() {
            let _ = self.transition(Transition::Stop, now, effects);
        }
        if self.state == State::Stopped {
            let _ = self.transition(Transition::Cleanup, now, effects);
        }
        if self.state.is_configured() {
            // it could not be stopped or cleaned up
            let component = &mut self.component;
            let tidied = guarded(|| {
                component.cleanup();
                Ok(())
            });
            if let Err(fault) = tidied {
                self.record_fault(fault, now, effects);
            }
            self.set_state(State::PreOperational, now, effects);
        }
        self.close(now, effects);
        let event = Event::Report {
            component: &self.name,
            kind: REMOVAL_REPORT,
            data: &Datum::text("from the running system"),
        };
        effects.emit(now, &event);
    }
}
