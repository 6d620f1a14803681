//! Plan of a system: a composite flattened for one profile, with promotions and renames resolved, substitutions applied
//! and defaults filled in. Lists keep the order of the files.

use std::collections::BTreeMap;

use asmotion_component::declaration::OperationDeclaration;
use asmotion_composite::NamedList;
use asmotion_datum::Schema;

use crate::component::Component;
use crate::connection_list::ConnectionList;
use crate::joint::{Promoted, Topic};
use crate::wire_list::WireList;
pub use asmotion_composite::address::Endpoint;
pub use asmotion_composite::end::{End, Terminal};
pub use asmotion_composite::model::{
    PlannedBridge as Bridge, PlannedBroker as Broker, PlannedGateway as Gateway,
    PlannedImplementation as Implementation, PlannedLifecycle as Lifecycle, PlannedPace as Pace,
    PlannedPolicy as Policy, PlannedProcess as Process, PlannedRecord as Record,
    PlannedRestart as Restart, PlannedWire as Wire, RecordReaders,
};
pub use asmotion_composite::value::PropertyValues;

/// A flattened composite for one profile.
#[derive(Clone, Debug, PartialEq)]
pub struct Plan {
    /// Name of the composite.
    pub name: String,
    /// Version of the composite; `None` if not given.
    pub version: Option<String>,
    /// Profile name; `None` if the composite has no profiles.
    pub profile: Option<String>,
    /// Unset environment variables, which prevent the plan from being started.
    pub missing: Vec<String>,
    /// Component names in start order: providers before callers, writers before readers.
    pub start_order: Vec<String>,
    /// Properties of the outermost composite.
    pub properties: PropertyValues,
    /// Brokers of all composites.
    pub brokers: Vec<Broker>,
    /// Gateways of the outermost composite.
    pub gateways: Vec<Gateway>,
    /// Bridges of all composites.
    pub bridges: Vec<Bridge>,
    /// Components in file order.
    pub components: NamedList<Component>,
    /// Topics in order of their names.
    pub topics: Vec<Topic>,
    /// Connections, one per pair of ends.
    pub connections: ConnectionList,
    /// Wires of all composites.
    pub wires: WireList,
    /// Elements visible outside the system.
    pub promoted: Vec<Promoted>,
    /// Processes; a single process with all components if the composite has no deployment.
    pub processes: Vec<Process>,
    /// Restart policy; `None` if the composite has none.
    pub restart: Option<Restart>,
    /// Recording settings; `None` if the composite has none.
    pub record: Option<Record>,
    /// Schemas by message type name; unknown types are absent.
    pub types: BTreeMap<String, Schema>,
    /// Operations by service interface, of those that only folders with definitions of ROS have.
    pub interfaces: BTreeMap<String, Vec<OperationDeclaration>>,
    /// Positions in `processes` by component; empty without a deployment.
    pub(crate) process_positions: BTreeMap<String, usize>,
    /// At least one component names a broker, so that those without one are local.
    pub(crate) has_component_broker: bool,
}

impl Plan {
    /// Returns the component of this qualified name.
    pub fn component(&self, name: &str) -> Option<&Component> {
        self.components.named(name)
    }

    /// Returns the process of a component of the plan; `None` if the component is unknown and there are several processes.
    pub fn process_of(&self, component: &str) -> Option<&Process> {
        match self.processes.as_slice() {
            [only] => Some(only),
            several => several.get(*self.process_positions.get(component)?),
        }
    }
}
