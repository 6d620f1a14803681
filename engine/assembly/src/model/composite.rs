//! The file as a whole.

use asmotion_diagnostics::FileId;

use super::{
    Bridge, Broker, Component, Connection, Deploy, Gateway, Promotion, Property, Topic, Wire,
};
use crate::At;

/// A composite file.
#[derive(Clone, Debug)]
pub struct Composite {
    /// The file it was read from.
    pub file: FileId,
    /// `composite.name`.
    pub name: At<String>,
    /// `composite.version`.
    pub version: Option<At<String>>,
    /// `composite.namespace`: that of its names in SCDL, which others may share.
    pub namespace: Option<At<String>>,
    /// `composite.doc`.
    pub doc: Option<At<String>>,
    /// `composite.types`: files with message types.
    pub types: Vec<At<String>>,
    /// `[properties]`: what an integrator may set.
    pub properties: Vec<Property>,
    /// `[brokers.<name>]`.
    pub brokers: Vec<Broker>,
    /// `[gateways.<name>]`.
    pub gateways: Vec<Gateway>,
    /// `[bridges.<name>]`.
    pub bridges: Vec<Bridge>,
    /// `[components.<name>]`, in the order of the file.
    pub components: Vec<Component>,
    /// `[topics.<name>]`.
    pub topics: Vec<Topic>,
    /// `[[wires]]`.
    pub wires: Vec<Wire>,
    /// `[[connections]]`.
    pub connections: Vec<Connection>,
    /// `[[promote]]`.
    pub promotions: Vec<Promotion>,
    /// `[deploy]`.
    pub deploy: Option<Deploy>,
}

impl Composite {
    /// The component of this name.
    pub fn component(&self, name: &str) -> Option<&Component> {
        self.components
            .iter()
            .find(|component| component.name.value == name)
    }

    /// The broker that a component is on, where components name theirs: a `task` stays inside unless it names one. An
    /// `activity` has no key for it, so where a connection joins it to a topic, it is on the composite's only broker.
    pub fn broker_of<'c>(&'c self, component: &'c Component) -> Option<&'c At<String>> {
        let of_pace = |it: &'c Component| it.pace.as_ref()?.broker.as_ref();
        let is_task = component.pace.as_ref().is_some_and(|pace| pace.is_task);
        let default = || match &*self.brokers {
            [only] if !is_task && self.components.iter().any(|it| of_pace(it).is_some()) => {
                let mut connections = self.connections.iter();
                let on_topic = |it: &Connection| it.joins_to_topic(&component.name.value);
                connections.any(on_topic).then_some(&only.name)
            }
            _ => None,
        };
        of_pace(component).or_else(default)
    }
}
