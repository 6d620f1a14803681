//! A composite in one profile, flattened: nested composites opened, promotions and renames
//! applied, substitutions made, defaults filled in. Plain data, in the order of the files.

mod component;
mod endpoint;
mod fill;
mod flatten;
mod graph;
mod join;
mod joint;
mod order;
mod part;
mod place;
mod route;
mod topic;
mod way;

use std::collections::BTreeMap;

use asmotion_datum::Schema;
use serde::{Serialize, Serializer};

use crate::value::Value;

pub use crate::check::DEFAULT_TIMEOUT_MS;
pub use component::{
    Asm, BuiltinSettings, Component, Idle, Implementation, Lifecycle, Notify, Pace, Plot, Port,
    ProxyEntry, RosEntry, Service, Verify,
};
pub(crate) use endpoint::mask;
pub use endpoint::{Bridge, Broker, Endpoint, Gateway};
pub(crate) use flatten::{Parts, flatten};
pub use graph::Link;
pub use joint::{Connection, End, Policy, Promoted, Terminal, Topic, Wire};
pub use place::{Process, Record, Restart};
pub use way::{Over, Way};

/// A composite in one profile, ready to be started.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Plan {
    /// The name of the composite.
    pub name: String,
    /// Its version.
    pub version: Option<String>,
    /// The profile; absent where the composite has none.
    pub profile: Option<String>,
    /// Environment variables that must be set before this can be started.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub missing: Vec<String>,
    /// The names of the components, providers before their callers, writers before their readers.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub start_order: Vec<String>,
    /// The properties of the outermost composite.
    #[serde(skip_serializing_if = "Settings::is_empty")]
    pub properties: Settings,
    /// Brokers.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub brokers: Vec<Broker>,
    /// Gateways.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub gateways: Vec<Gateway>,
    /// Bridges.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub bridges: Vec<Bridge>,
    /// Components, in the order of the files.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub components: Vec<Component>,
    /// Topics, by name.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub topics: Vec<Topic>,
    /// Connections, one for each pair of ends.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub connections: Vec<Connection>,
    /// Wires.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub wires: Vec<Wire>,
    /// What the outside sees.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub promoted: Vec<Promoted>,
    /// Processes; one that has everything where the composite says nothing.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub processes: Vec<Process>,
    /// When a process is started again.
    pub restart: Option<Restart>,
    /// What is written down.
    pub record: Option<Record>,
    /// What the types look like that ports name, as far as anybody says.
    #[serde(skip)]
    pub types: BTreeMap<String, Schema>,
}

/// Names and values, in the order they were declared or set.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Settings(pub Vec<(String, Value)>);

impl Plan {
    /// The plan as TOML: the composite with everything filled in, secrets left out.
    ///
    /// # Errors
    /// A value that TOML cannot write.
    pub fn to_toml(&self) -> Result<String, toml::ser::Error> {
        toml::to_string(self)
    }

    /// The component of this name.
    pub fn component(&self, name: &str) -> Option<&Component> {
        self.components
            .iter()
            .find(|component| component.name == name)
    }
}

impl Settings {
    fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// The value of a property.
    pub fn get(&self, name: &str) -> Option<&Value> {
        self.0
            .iter()
            .find(|(known, _)| known == name)
            .map(|(_, value)| value)
    }
}

impl Serialize for Settings {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_map(self.0.iter().map(|(name, value)| (name, value)))
    }
}
