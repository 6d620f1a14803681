//! What a component's runtime can do to its surroundings. Each executor brings its own.

use std::sync::Arc;

use asmotion_port::Time;

use crate::event::Event;

/// The surroundings of a component: the executor and the observers. Called by the thread that has the component.
pub trait Effects {
    /// Tells the observers.
    fn emit(&mut self, at: Time, event: &Event<'_>);

    /// Something new is there for the component at this position; an event-driven one cycles.
    fn trigger(&mut self, component: usize);

    /// A call of a component ends at this time, if no answer comes before.
    fn wake_at(&mut self, component: usize, at: Time);

    /// A component has failed, and its activity wants all components stopped for that.
    fn escalate(&mut self, component: usize);

    /// The next position among all samples of the run.
    fn next_order(&mut self) -> u64;
}

/// No effects, for callers outside of any component.
pub(crate) struct NoEffects;

impl Effects for NoEffects {
    fn emit(&mut self, _: Time, _: &Event<'_>) {}

    fn trigger(&mut self, _: usize) {}

    fn wake_at(&mut self, _: usize, _: Time) {}

    fn escalate(&mut self, _: usize) {}

    fn next_order(&mut self) -> u64 {
        0
    }
}

/// The effects of one component at one instant.
pub(crate) struct ComponentEffects<'a> {
    pub now: Time,
    /// The component's position in the system.
    pub component: usize,
    pub name: &'a Arc<str>,
    pub effects: &'a mut dyn Effects,
}

impl ComponentEffects<'_> {
    pub(crate) fn emit(&mut self, event: &Event<'_>) {
        self.effects.emit(self.now, event);
    }
}
