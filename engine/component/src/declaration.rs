//! What a component declares, as plain data: for the checker, for introspection, for people.

use asmotion_datum::{Datum, Schema};
use serde::{Deserialize, Serialize};

/// Everything a component declares in its constructor.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct Declaration {
    /// Input ports, in order of declaration.
    pub inputs: Vec<PortDeclaration>,
    /// Output ports.
    pub outputs: Vec<PortDeclaration>,
    /// Services it provides.
    pub services: Vec<ServiceDeclaration>,
    /// References it requires.
    pub references: Vec<ReferenceDeclaration>,
    /// Properties.
    pub properties: Vec<PropertyDeclaration>,
}

/// A port.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct PortDeclaration {
    /// Its name, unique among the component's ports of its direction.
    pub name: String,
    /// Name and shape of what passes; the shape of a port declared by type name is any.
    pub schema: Schema,
    /// What it is for.
    pub doc: String,
}

/// A service that a component provides.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ServiceDeclaration {
    /// Its name.
    pub name: String,
    /// Its interface: `nav/PlanService`.
    pub interface: String,
    /// What it is for.
    pub doc: String,
    /// The operations served.
    pub operations: Vec<OperationDeclaration>,
}

/// A reference to a service that a component requires.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ReferenceDeclaration {
    /// Its name.
    pub name: String,
    /// The interface required.
    pub interface: String,
    /// What it is for.
    pub doc: String,
    /// Whether the component does without if need be.
    pub optional: bool,
    /// The operations called.
    pub operations: Vec<OperationDeclaration>,
}

/// An operation of a service or a reference.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct OperationDeclaration {
    /// Its name in the interface.
    pub name: String,
    /// What is sent.
    pub request: Schema,
    /// What is answered.
    pub response: Schema,
}

/// A property.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct PropertyDeclaration {
    /// Its name, unique in the component.
    pub name: String,
    /// What it is for.
    pub doc: String,
    /// Its type.
    pub schema: Schema,
    /// Its unit: `m/s`; empty for none.
    pub unit: String,
    /// Its value, unless one is set.
    pub default: Datum,
    /// Least and greatest value, both lawful.
    pub range: Option<(Datum, Datum)>,
    /// All lawful values, if they can be listed.
    pub choices: Vec<Datum>,
}

impl Declaration {
    /// An input port by name.
    pub fn input(&self, name: &str) -> Option<&PortDeclaration> {
        self.inputs.iter().find(|port| port.name == name)
    }

    /// An output port by name.
    pub fn output(&self, name: &str) -> Option<&PortDeclaration> {
        self.outputs.iter().find(|port| port.name == name)
    }

    /// A service by name.
    pub fn service(&self, name: &str) -> Option<&ServiceDeclaration> {
        self.services.iter().find(|service| service.name == name)
    }

    /// A reference by name.
    pub fn reference(&self, name: &str) -> Option<&ReferenceDeclaration> {
        (self.references.iter()).find(|reference| reference.name == name)
    }

    /// A property by name.
    pub fn property(&self, name: &str) -> Option<&PropertyDeclaration> {
        (self.properties.iter()).find(|property| property.name == name)
    }
}

/// Two declarations that do not go together.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum DeclarationError {
    /// A name declared twice.
    #[error("{what} `{name}` is declared twice")]
    Twice {
        /// Input, output, property, operation.
        what: &'static str,
        /// The name.
        name: String,
    },
    /// Operations of two interfaces under one name.
    #[error("`{name}` is declared for interface `{first}` and for `{second}`")]
    TwoInterfaces {
        /// The service or reference.
        name: String,
        /// The interface declared first.
        first: String,
        /// The other.
        second: String,
    },
    /// A default outside of its own range.
    #[error("the default of property `{name}` is not one of its lawful values: {reason}")]
    BadDefault {
        /// The property.
        name: String,
        /// Why.
        reason: String,
    },
}
