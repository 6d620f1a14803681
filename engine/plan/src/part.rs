//! The subset of a plan that runs in a process.

use std::collections::BTreeSet;

use crate::plan::{Plan, Process};

/// Subset of a plan that runs in one process.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Part {
    /// All components, connected directly.
    Whole,
    /// All components; topics and wires use the bus.
    WholeOverBus,
    /// The named components. Connections between them are direct; connections to others use the bus.
    Components(BTreeSet<String>),
}

impl Part {
    /// All components in one process, using the brokers named in the composite.
    pub fn with_brokers(plan: &Plan) -> Self {
        Self::Components(plan.components.iter().map(|it| it.name.clone()).collect())
    }

    /// The components deployed to a process.
    pub fn of(process: &Process) -> Self {
        Self::Components(process.components.iter().cloned().collect())
    }

    /// Returns whether a component belongs to this part.
    pub fn has(&self, component: &str) -> bool {
        match self {
            Self::Whole | Self::WholeOverBus => true,
            Self::Components(components) => components.contains(component),
        }
    }

    /// Returns whether no bus is needed.
    pub fn is_alone(&self) -> bool {
        *self == Self::Whole
    }

    /// Returns whether topics and wires between its own components use the bus, too.
    pub fn takes_the_bus_inside(&self) -> bool {
        *self == Self::WholeOverBus
    }
}
