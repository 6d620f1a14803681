//! What a component's runtime can do to the world around it. Each executor has its own.

use std::sync::Arc;

use crate::{Event, Time};

/// The world around a component: the executor, the observers.
pub(crate) trait Outside {
    /// Tells the observers.
    fn emit(&mut self, at: Time, event: &Event<'_>);

    /// Something new is there for a component; one that is event-driven runs.
    fn trigger(&mut self, component: usize);

    /// A call of a component ends at this time, if no answer comes.
    fn wake_at(&mut self, component: usize, at: Time);

    /// A component has failed, and all are to stop for it.
    fn escalate(&mut self, component: usize);

    /// The next place among all samples of the run.
    fn next_order(&mut self) -> u64;
}

/// No world: for those who want nothing of it.
pub(crate) struct Nowhere;

impl Outside for Nowhere {
    fn emit(&mut self, _: Time, _: &Event<'_>) {}

    fn trigger(&mut self, _: usize) {}

    fn wake_at(&mut self, _: usize, _: Time) {}

    fn escalate(&mut self, _: usize) {}

    fn next_order(&mut self) -> u64 {
        0
    }
}

/// A component in the act of committing: who, when, and into which world.
pub(crate) struct Leaving<'a> {
    pub now: Time,
    /// The component's place in the system.
    pub me: usize,
    pub name: &'a Arc<str>,
    pub outside: &'a mut dyn Outside,
}

impl Leaving<'_> {
    pub(crate) fn emit(&mut self, event: &Event<'_>) {
        self.outside.emit(self.now, event);
    }
}
