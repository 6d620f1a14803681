//! Ports, services and properties of a component, as visible to wires and connections.

pub use crate::named::{NamedAt, TypeAt};
use crate::nearest::{Nearest, nearest};

/// Ports, services, references and properties of a component, merged from the composite, the implementation and
/// promotions of a nested composite.
#[derive(Clone, Debug, Default)]
pub struct Endpoints {
    /// Input ports; those listed in the composite come first.
    pub inputs: Vec<EndpointPort>,
    /// Output ports; those listed in the composite come first.
    pub outputs: Vec<EndpointPort>,
    /// Provided services.
    pub services: Vec<EndpointService>,
    /// Required references.
    pub references: Vec<EndpointService>,
    /// Topics promoted by a nested composite.
    pub topics: Vec<PromotedTopic>,
    /// `None` if the properties are unknown.
    pub properties: Option<Vec<NamedAt>>,
    /// Set if the implementation could not be read; no name is then reported as unknown.
    pub blank: bool,
}

/// A port of a component.
#[derive(Clone, Debug)]
pub struct EndpointPort {
    /// Name within the component.
    pub name: NamedAt,
    /// Message type and its source location; `None` if unknown.
    pub kind: Option<TypeAt>,
    /// Topic of the port.
    pub topic: Option<String>,
    /// Whether the composite lists the port; `false` if only the implementation declares it.
    pub listed: bool,
    /// Whether it is an input that the implementation reads if it is connected.
    pub optional: bool,
}

/// A service or a reference.
#[derive(Clone, Debug, PartialEq)]
pub struct EndpointService {
    /// Name within the component.
    pub name: NamedAt,
    /// Service interface.
    pub interface: TypeAt,
    /// `true` for a reference that may remain unconnected; always `false` for services.
    pub optional: bool,
}

/// A promoted topic.
#[derive(Clone, Debug, PartialEq)]
pub struct PromotedTopic {
    /// Public name.
    pub name: NamedAt,
    /// Message type; `None` if no port on the topic has one.
    pub kind: Option<TypeAt>,
    /// `true` if an inner component publishes to the topic.
    pub published: bool,
    /// `true` if an inner component subscribes to the topic.
    pub subscribed: bool,
}

/// Direction of a port.
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
    /// Returns whether two components have the same endpoints, except for the topics of the ports.
    pub fn differs_in_topics_only(&self, other: &Self) -> bool {
        let is_same = |(one, other): (&EndpointPort, &EndpointPort)| {
            one.name == other.name
                && one.kind == other.kind
                && one.listed == other.listed
                && one.optional == other.optional
        };
        let are_same = |one: &[EndpointPort], other: &[EndpointPort]| {
            one.len() == other.len() && one.iter().zip(other).all(is_same)
        };
        are_same(&self.inputs, &other.inputs)
            && are_same(&self.outputs, &other.outputs)
            && self.services == other.services
            && self.references == other.references
            && self.topics == other.topics
            && self.properties == other.properties
            && self.blank == other.blank
    }

    /// Looks up a port by name, preferring the wanted direction.
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

    /// Returns the port whose name is most similar to a misspelled one.
    pub(crate) fn nearest_port(&self, name: &str) -> Option<Nearest> {
        let ports = self.inputs.iter().chain(&self.outputs);
        nearest(
            name,
            ports.map(|port| (port.name.text.as_str(), port.name.at)),
        )
    }
}

/// Looks up a service or reference by name.
pub fn find<'s>(services: &'s [EndpointService], name: &str) -> Option<&'s EndpointService> {
    services.iter().find(|service| service.name.text == name)
}

/// Returns the service or reference whose name is most similar to a misspelled one.
pub(crate) fn nearest_service(services: &[EndpointService], name: &str) -> Option<Nearest> {
    nearest(
        name,
        services
            .iter()
            .map(|service| (service.name.text.as_str(), service.name.at)),
    )
}
