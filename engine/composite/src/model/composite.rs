//! The composite file.

use asmotion_derive::Table;
use asmotion_diagnostics::{FileId, Span};

use super::{
    Bridge, Broker, Component, Connection, Deploy, Gateway, Promotion, Property, Topic, Wire,
};
use crate::at::At;
use crate::table::Dialect;

/// A composite file.
#[derive(Clone, Debug, Table)]
#[table(of = "a composite file")]
pub struct Composite {
    /// File identifier in the source map.
    pub file: FileId,
    /// Dialect and version of the file.
    #[key(needed, example = "\"composite/1\"")]
    pub schema: Option<Dialect>,
    /// Base composite: tables of the same name are merged, other values override those of the base.
    #[key(example = "\"navigation.composite.toml\"")]
    pub base: Option<At<String>>,
    /// Elements of the base left out: paths of keys, such as `components.Joystick`, and connections, wires or promotions by
    /// their ends, such as `connections.Joystick.twist -> Rover.twist`.
    #[key(example = "[\"components.Joystick\", \"connections.Joystick.twist\"]")]
    pub without: Vec<At<String>>,
    /// Name and description of the composite.
    #[key(
        name = "composite",
        needed,
        or_default,
        example = "{ name = \"navigation\" }"
    )]
    pub head: Head,
    /// Properties set by the integrator.
    #[key(example = "{ }")]
    pub properties: Vec<Property>,
    /// Message brokers.
    #[key(example = "{ }")]
    pub brokers: Vec<Broker>,
    /// HTTP gateways for promoted services.
    #[key(example = "{ }")]
    pub gateways: Vec<Gateway>,
    /// Bridges to other middleware.
    #[key(example = "{ }")]
    pub bridges: Vec<Bridge>,
    /// Components; the order determines which cycles first if several are due at once.
    #[key(example = "{ }")]
    pub components: Vec<Component>,
    /// Settings of topics sent over a broker.
    #[key(example = "{ }")]
    pub topics: Vec<Topic>,
    /// Connections from references to services.
    #[key(example = "[[wires]]")]
    pub wires: Vec<Wire>,
    /// Connections from output ports to input ports.
    #[key(example = "[[connections]]")]
    pub connections: Vec<Connection>,
    /// Elements visible outside the composite.
    #[key(name = "promote", example = "[[promote]]")]
    pub promotions: Vec<Promotion>,
    /// Assignment of components to processes; a single process by default.
    #[key(example = "{ }")]
    pub deploy: Option<Deploy>,
}

/// Name and description of a composite.
#[derive(Clone, Debug, Default, Table)]
#[table(of = "`composite`", example = "{ name = \"navigation\" }")]
pub struct Head {
    /// Name of the composite; also the name of the robot on the bus unless another is given at startup.
    #[key(needed, example = "\"navigation\"", form = thing)]
    pub name: Option<At<String>>,
    /// Version of the composite, shown by `asmotion describe`.
    #[key(example = "\"1.0.0\"")]
    pub version: Option<At<String>>,
    /// SCDL namespace of its names; may be shared with other composites.
    #[key(example = "\"http://robots.example/navigation\"")]
    pub namespace: Option<At<String>>,
    /// Description.
    #[key(example = "\"Navigation of a rover\"")]
    pub doc: Option<At<String>>,
    /// Files with message types.
    #[key(example = "[\"types.toml\"]")]
    pub types: Vec<At<String>>,
}

impl Composite {
    /// Returns the name of the composite; `composite` if it could not be read.
    pub fn name(&self) -> At<String> {
        let unknown = || At::new("composite".to_owned(), Span::new(self.file, 0, 0));
        self.head.name.clone().unwrap_or_else(unknown)
    }

    /// Returns the component of this name.
    pub fn component(&self, name: &str) -> Option<&Component> {
        self.components
            .iter()
            .find(|component| component.name.value == name)
    }
}
