//! The file as a whole.

use source::FileId;

use super::{Bridge, Broker, Component, Connection, Deploy, Promotion, Property, Topic, Wire};
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
}
