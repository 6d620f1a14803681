//! Which part of a plan runs in a process, and what of it goes over a bus.

use std::collections::BTreeSet;

use crate::plan::{Plan, Process};

/// The part of a plan that runs in a process.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Part {
    /// All of it, joined directly.
    Whole,
    /// All of it, its topics and wires over the bus.
    WholeOverBus,
    /// Some components. What joins two of them is direct, what joins them to others is over the bus.
    Components(BTreeSet<String>),
}

impl Part {
    /// All components, in one process, and what the composite has over its brokers goes over them.
    pub fn with_brokers(plan: &Plan) -> Self {
        Self::Components(plan.components.iter().map(|it| it.name.clone()).collect())
    }

    /// The components deployed to a process.
    pub fn of(process: &Process) -> Self {
        Self::Components(process.components.iter().cloned().collect())
    }

    /// Whether a component is of this part.
    pub fn has(&self, component: &str) -> bool {
        match self {
            Self::Whole | Self::WholeOverBus => true,
            Self::Components(components) => components.contains(component),
        }
    }

    /// Whether there is nobody else: no bus is needed.
    pub fn is_alone(&self) -> bool {
        *self == Self::Whole
    }

    /// Whether topics and wires between its own components go over the bus, too.
    pub fn takes_the_bus_inside(&self) -> bool {
        *self == Self::WholeOverBus
    }
}
