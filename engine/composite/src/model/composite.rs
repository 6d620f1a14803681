//! The file as a whole.

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
    /// The file it was read from.
    pub file: FileId,
    /// The dialect of the file.
    #[key(needed, example = "\"composite/1\"")]
    pub schema: Option<Dialect>,
    /// The composite that this one is laid over: tables of one name become one, anything else takes the place of what was
    /// there.
    #[key(example = "\"navigation.composite.toml\"")]
    pub base: Option<At<String>>,
    /// The composite itself.
    #[key(
        name = "composite",
        needed,
        or_default,
        example = "{ name = \"navigation\" }"
    )]
    pub head: Head,
    /// What an integrator may set.
    #[key(example = "{ }")]
    pub properties: Vec<Property>,
    /// Message brokers.
    #[key(example = "{ }")]
    pub brokers: Vec<Broker>,
    /// Where promoted services are called over HTTP.
    #[key(example = "{ }")]
    pub gateways: Vec<Gateway>,
    /// Ways to other middlewares.
    #[key(example = "{ }")]
    pub bridges: Vec<Bridge>,
    /// The components, in the order in which they cycle where two are due at once.
    #[key(example = "{ }")]
    pub components: Vec<Component>,
    /// How topics go over a broker.
    #[key(example = "{ }")]
    pub topics: Vec<Topic>,
    /// References and the services that answer them.
    #[key(example = "[[wires]]")]
    pub wires: Vec<Wire>,
    /// What carries messages from outputs to inputs.
    #[key(example = "[[connections]]")]
    pub connections: Vec<Connection>,
    /// What the outside sees.
    #[key(name = "promote", example = "[[promote]]")]
    pub promotions: Vec<Promotion>,
    /// Which process runs what; one runs everything, if absent.
    #[key(example = "{ }")]
    pub deploy: Option<Deploy>,
}

/// What a composite is called, and what it is for.
#[derive(Clone, Debug, Default, Table)]
#[table(of = "`composite`", example = "{ name = \"navigation\" }")]
pub struct Head {
    /// Its name: the robot's on the bus, unless another one is given when it is started.
    #[key(needed, example = "\"navigation\"")]
    pub name: Option<At<String>>,
    /// Its version.
    #[key(example = "\"1.0.0\"")]
    pub version: Option<At<String>>,
    /// Namespace of its names in SCDL, which others may share.
    #[key(example = "\"http://robots.example/navigation\"")]
    pub namespace: Option<At<String>>,
    /// What it is for.
    #[key(example = "\"what it is for\"")]
    pub doc: Option<At<String>>,
    /// Files with message types.
    #[key(example = "[\"types.toml\"]")]
    pub types: Vec<At<String>>,
}

impl Composite {
    /// Its name; `composite`, where it could not be read.
    pub fn name(&self) -> At<String> {
        let unknown = || At::new("composite".to_owned(), Span::new(self.file, 0, 0));
        self.head.name.clone().unwrap_or_else(unknown)
    }

    /// The component of this name.
    pub fn component(&self, name: &str) -> Option<&Component> {
        self.components
            .iter()
            .find(|component| component.name.value == name)
    }

    /// The broker that a component is on, where components name theirs: a `task` stays inside unless it names one. An
    /// `activity` has no key for it, so where a connection joins it to a topic, it is on the composite's only broker.
    pub fn broker_of<'c>(&'c self, component: &'c Component) -> Option<&'c At<String>> {
        let of_pace = |it: &'c Component| it.pace()?.broker.as_ref();
        let is_task = component.task.is_some();
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
