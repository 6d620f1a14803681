//! A component's declaration as plain data, for checks, introspection and documentation.

use asmotion_datum::{Datum, Message, Schema};
use serde::{Deserialize, Serialize};

use crate::conversion::PropertyConversion;
use crate::operation::Operation;

/// The declarations of a component's constructor.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct Declaration {
    /// Input ports, in order of declaration.
    #[serde(default)]
    pub inputs: Vec<PortDeclaration>,
    /// Output ports, in order of declaration.
    #[serde(default)]
    pub outputs: Vec<PortDeclaration>,
    /// Provided services, in order of declaration.
    #[serde(default)]
    pub services: Vec<ServiceDeclaration>,
    /// Required references, in order of declaration.
    #[serde(default)]
    pub references: Vec<ReferenceDeclaration>,
    /// Properties, in order of declaration.
    #[serde(default)]
    pub properties: Vec<PropertyDeclaration>,
}

/// Declaration of a port.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct PortDeclaration {
    /// Name, unique among the component's ports of the same direction.
    pub name: String,
    /// Name and fields of the message type; the fields of a port declared by type name alone are unknown.
    pub schema: Schema,
    /// Purpose of the port, in one line.
    #[serde(default)]
    pub doc: String,
    /// Sample that the engine writes after the component's last cycle; `None` without one, and for inputs.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub safe: Option<Datum>,
    /// Whether its samples are commands, which the component must not carry out late: those that arrive while it does not run
    /// are discarded when it starts. `false` for outputs.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub command: bool,
    /// Whether it is an input that may remain without a connection. `false` for outputs.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub optional: bool,
}

/// A service that a component provides.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ServiceDeclaration {
    /// Name, unique among the component's services.
    pub name: String,
    /// Name of the interface, for example `nav/PlanService`.
    pub interface: String,
    /// Purpose of the service, in one line.
    #[serde(default)]
    pub doc: String,
    /// The operations provided.
    #[serde(default)]
    pub operations: Vec<OperationDeclaration>,
}

/// A reference to a service that a component requires.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ReferenceDeclaration {
    /// Name, unique among the component's references.
    pub name: String,
    /// Name of the required interface.
    pub interface: String,
    /// Purpose of the reference, in one line.
    #[serde(default)]
    pub doc: String,
    /// `true` if the component also works without a service.
    #[serde(default)]
    pub optional: bool,
    /// The operations called.
    #[serde(default)]
    pub operations: Vec<OperationDeclaration>,
}

/// An operation of a service or a reference.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct OperationDeclaration {
    /// Name, unique in the interface.
    pub name: String,
    /// Type of the request.
    pub request: Schema,
    /// Type of the response.
    pub response: Schema,
    /// Whether it is also answered while the component is stopped.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub while_stopped: bool,
}

impl OperationDeclaration {
    /// The declaration of an operation of the program; not answered while stopped.
    pub fn of<O: Operation>() -> Self {
        Self {
            name: O::NAME.to_owned(),
            request: O::Request::schema().clone(),
            response: O::Response::schema().clone(),
            while_stopped: false,
        }
    }

    /// An operation of which only the name is known.
    pub fn opaque(name: impl Into<String>) -> Self {
        Self {
            name: name.into(),
            request: Schema::opaque(""),
            response: Schema::opaque(""),
            while_stopped: false,
        }
    }
}

/// Declaration of a property.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct PropertyDeclaration {
    /// Name, unique in the component.
    pub name: String,
    /// Purpose of the property, in one line.
    #[serde(default)]
    pub doc: String,
    /// Type of the value.
    pub schema: Schema,
    /// Unit of the value, for example `m/s`; empty without one.
    #[serde(default)]
    pub unit: String,
    /// The value used unless the composite sets one.
    pub default: Datum,
    /// Least and greatest allowed value, inclusive; `None` without a limit.
    #[serde(default)]
    pub range: Option<(Datum, Datum)>,
    /// All allowed values, if they are enumerated; else empty.
    #[serde(default)]
    pub choices: Vec<Datum>,
    /// Conversion to the property's type.
    #[serde(skip)]
    pub conversion: PropertyConversion,
}

impl Declaration {
    /// Releases the memory that the lists do not use.
    pub(crate) fn shrink(&mut self) {
        self.inputs.shrink_to_fit();
        self.outputs.shrink_to_fit();
        self.services.shrink_to_fit();
        self.references.shrink_to_fit();
        self.properties.shrink_to_fit();
    }

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
        self.references
            .iter()
            .find(|reference| reference.name == name)
    }

    /// A property by name.
    pub fn property(&self, name: &str) -> Option<&PropertyDeclaration> {
        self.properties
            .iter()
            .find(|property| property.name == name)
    }
}

/// A contradiction between declarations of a component.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum DeclarationError {
    /// Two declarations of the same kind with the same name.
    #[error("duplicate {kind} `{name}`")]
    Duplicate {
        /// The kind: input, output, property or operation.
        kind: &'static str,
        /// The name in question.
        name: String,
    },
    /// Operations of two interfaces under one name.
    #[error("`{name}` is declared for interface `{first}` and for `{second}`")]
    ConflictingInterfaces {
        /// Name of the service or reference.
        name: String,
        /// The interface declared first.
        first: String,
        /// The interface declared later.
        second: String,
    },
    /// A default that is not among the allowed values.
    #[error("invalid default of property `{name}`: {reason}")]
    InvalidDefault {
        /// Name of the property.
        name: String,
        /// The violated limit.
        reason: String,
    },
}
