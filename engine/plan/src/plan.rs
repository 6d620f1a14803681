//! A composite in one profile, flattened: nested composites opened, promotions and renames
//! applied, substitutions made, defaults filled in. Plain data, in the order of the files.

use std::collections::BTreeMap;

use asmotion_datum::Schema;

use crate::component::Component;
use crate::joint::{Connection, Promoted, Topic};
pub use asmotion_composite::address::Endpoint;
pub use asmotion_composite::end::{End, Terminal};
pub use asmotion_composite::model::{
    PlannedBridge as Bridge, PlannedBroker as Broker, PlannedGateway as Gateway,
    PlannedLifecycle as Lifecycle, PlannedPace as Pace, PlannedPolicy as Policy,
    PlannedProcess as Process, PlannedRecord as Record, PlannedRestart as Restart,
    PlannedWire as Wire,
};
pub use asmotion_composite::value::PropertyValues;

/// A composite in one profile, ready to be started.
#[derive(Clone, Debug, PartialEq)]
pub struct Plan {
    /// The name of the composite.
    pub name: String,
    /// Its version.
    pub version: Option<String>,
    /// The profile; absent where the composite has none.
    pub profile: Option<String>,
    /// Environment variables that must be set before this can be started.
    pub missing: Vec<String>,
    /// The names of the components, providers before their callers, writers before their readers.
    pub start_order: Vec<String>,
    /// The properties of the outermost composite.
    pub properties: PropertyValues,
    /// Brokers.
    pub brokers: Vec<Broker>,
    /// Gateways.
    pub gateways: Vec<Gateway>,
    /// Bridges.
    pub bridges: Vec<Bridge>,
    /// Components, in the order of the files.
    pub components: Vec<Component>,
    /// Topics, by name.
    pub topics: Vec<Topic>,
    /// Connections, one for each pair of ends.
    pub connections: Vec<Connection>,
    /// Wires.
    pub wires: Vec<Wire>,
    /// What the outside sees.
    pub promoted: Vec<Promoted>,
    /// Processes; one that has everything where the composite says nothing.
    pub processes: Vec<Process>,
    /// When a process is started again.
    pub restart: Option<Restart>,
    /// What is written down.
    pub record: Option<Record>,
    /// What the types look like that ports name, as far as anybody says.
    pub types: BTreeMap<String, Schema>,
}

impl Plan {
    /// The component of this name.
    pub fn component(&self, name: &str) -> Option<&Component> {
        self.components
            .iter()
            .find(|component| component.name == name)
    }

    /// The process that a component is placed in.
    pub fn process_of(&self, component: &str) -> Option<&Process> {
        let mut processes = self.processes.iter();
        processes.find(|process| process.components.iter().any(|it| it == component))
    }
}
