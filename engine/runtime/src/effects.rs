//! The surroundings of a component, as its runtime acts on them. Each executor has its own implementation.

use std::sync::Arc;

use asmotion_port::Time;

use crate::event::Event;

/// The surroundings of a component: the executor and the observers. Called by the thread that owns the component.
pub trait Effects {
    /// Reports an event to the observers.
    fn emit(&mut self, at: Time, event: &Event<'_>);

    /// Returns whether any observer uses reports of this kind.
    fn wants_report(&self, kind: &str) -> bool;

    /// Signals new data for the component at this position; an event-driven one cycles.
    fn trigger(&mut self, component: usize);

    /// Asks to wake the component at this time, when one of its calls reaches its deadline or the cycle that it has requested
    /// is due.
    fn wake_at(&mut self, component: usize, at: Time);

    /// Reports that a component has failed whose activity stops all components.
    fn escalate(&mut self, component: usize);

    /// Returns the next order number among all samples of the run.
    fn next_order(&mut self) -> u64;
}

/// Ignores all effects, for callers outside of any component. Samples get the order number 0.
pub(crate) struct NoEffects;

impl Effects for NoEffects {
    fn emit(&mut self, _: Time, _: &Event<'_>) {}

    fn wants_report(&self, _: &str) -> bool {
        false
    }

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
    /// Position of the component in the system.
    pub component: usize,
    pub name: &'a Arc<str>,
    pub effects: &'a mut dyn Effects,
}

impl ComponentEffects<'_> {
    pub(crate) fn emit(&mut self, event: &Event<'_>) {
        self.effects.emit(self.now, event);
    }
}
