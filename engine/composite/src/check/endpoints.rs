//! What a component shows to the wires and connections around it.

pub use crate::named::{NamedAt, TypeAt};
use crate::nearest::{Nearest, nearest};

/// What a component shows: what the composite lists, what the implementation declares, or what a
/// nested composite promotes.
#[derive(Clone, Debug, Default)]
pub struct Endpoints {
    /// Input ports, those that the composite lists first.
    pub inputs: Vec<EndpointPort>,
    /// Output ports, those that the composite lists first.
    pub outputs: Vec<EndpointPort>,
    /// Services it provides.
    pub services: Vec<EndpointService>,
    /// References it needs.
    pub references: Vec<EndpointService>,
    /// Topics that a nested composite promotes.
    pub topics: Vec<PromotedTopic>,
    /// `None` where nobody knows which there are.
    pub properties: Option<Vec<NamedAt>>,
    /// Nothing is known: the implementation could not be read, so no name can be wrong.
    pub blank: bool,
}

/// A port.
#[derive(Clone, Debug)]
pub struct EndpointPort {
    /// Name within the component.
    pub name: NamedAt,
    /// The type of its messages and its place; `None` where nobody knows.
    pub kind: Option<TypeAt>,
    /// The topic it is on.
    pub topic: Option<String>,
    /// Whether the composite lists it; otherwise only the implementation declares it.
    pub listed: bool,
}

/// A service or a reference.
#[derive(Clone, Debug)]
pub struct EndpointService {
    /// Name within the component.
    pub name: NamedAt,
    /// The interface with its operations.
    pub interface: TypeAt,
    /// `true` for a reference that may stay without a service.
    pub optional: bool,
}

/// A promoted topic.
#[derive(Clone, Debug)]
pub struct PromotedTopic {
    /// Name outside of the composite.
    pub name: NamedAt,
    /// The type of its messages; `None` where no port on it has one.
    pub kind: Option<TypeAt>,
    /// `true` if a component inside publishes it.
    pub published: bool,
    /// `true` if a component inside subscribes to it.
    pub subscribed: bool,
}

/// Which way messages go through a port.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum PortDirection {
    In,
    Out,
}

impl PortDirection {
    fn other(self) -> Self {
        match self {
            Self::In => Self::Out,
            Self::Out => Self::In,
        }
    }

    pub(crate) fn word(self) -> &'static str {
        match self {
            Self::In => "input",
            Self::Out => "output",
        }
    }
}

impl Endpoints {
    /// The port of this name, of the wanted direction if there is one.
    pub(crate) fn port(
        &self,
        name: &str,
        wanted: PortDirection,
    ) -> Option<(PortDirection, &EndpointPort)> {
        let find = |way: PortDirection| {
            let ports = match way {
                PortDirection::In => &self.inputs,
                PortDirection::Out => &self.outputs,
            };
            ports
                .iter()
                .find(|port| port.name.text == name)
                .map(|port| (way, port))
        };
        find(wanted).or_else(|| find(wanted.other()))
    }

    /// The port that a misspelt name resembles.
    pub(crate) fn nearest_port(&self, name: &str) -> Option<Nearest> {
        let ports = self.inputs.iter().chain(&self.outputs);
        nearest(
            name,
            ports.map(|port| (port.name.text.as_str(), port.name.at)),
        )
    }
}

/// The service or reference of this name.
pub fn find<'s>(services: &'s [EndpointService], name: &str) -> Option<&'s EndpointService> {
    services.iter().find(|service| service.name.text == name)
}

/// The service or reference that a misspelt name resembles.
pub(crate) fn nearest_service(services: &[EndpointService], name: &str) -> Option<Nearest> {
    nearest(
        name,
        services
            .iter()
            .map(|service| (service.name.text.as_str(), service.name.at)),
    )
}
