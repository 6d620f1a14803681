//! What this build has: components, messages, operations. The robot's crates fill it; this crate
//! only asks.

use datum::Schema;

use crate::Value;
use crate::model::Builtin;

/// What this build has.
pub trait Catalogue {
    /// The names under `implementation.rust`.
    fn components(&self) -> Vec<String>;

    /// What the component of this name declares in its constructor.
    fn declaration(&self, component: &str) -> Option<Declaration>;

    /// Whether this built-in is in this build.
    fn has(&self, builtin: Builtin) -> bool;

    /// The names of all message types.
    fn messages(&self) -> Vec<String>;

    /// What a message looks like.
    fn schema(&self, message: &str) -> Option<Schema>;

    /// The operations of an interface; `None` where the interface is not known.
    fn operations(&self, interface: &str) -> Option<Vec<Operation>>;
}

/// A build that has nothing: what a composite says of its components is believed.
#[derive(Clone, Copy, Debug, Default)]
pub struct EmptyCatalogue;

impl Catalogue for EmptyCatalogue {
    fn components(&self) -> Vec<String> {
        Vec::new()
    }

    fn declaration(&self, _: &str) -> Option<Declaration> {
        None
    }

    fn has(&self, _: Builtin) -> bool {
        false
    }

    fn messages(&self) -> Vec<String> {
        Vec::new()
    }

    fn schema(&self, _: &str) -> Option<Schema> {
        None
    }

    fn operations(&self, _: &str) -> Option<Vec<Operation>> {
        None
    }
}

/// What a component declares.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Declaration {
    /// Input ports.
    pub inputs: Vec<Port>,
    /// Output ports.
    pub outputs: Vec<Port>,
    /// Services it provides.
    pub services: Vec<Service>,
    /// References it needs.
    pub references: Vec<Service>,
    /// Properties it reads.
    pub properties: Vec<PropertyInfo>,
}

/// A port.
#[derive(Clone, Debug, PartialEq)]
pub struct Port {
    /// Its name.
    pub name: String,
    /// The type of its messages; empty where only the composite knows.
    pub type_name: String,
}

/// A service or a reference.
#[derive(Clone, Debug, PartialEq)]
pub struct Service {
    /// Its name.
    pub name: String,
    /// Its interface.
    pub interface: String,
    /// Whether a reference may stay without a service.
    pub optional: bool,
}

/// An operation of an interface.
#[derive(Clone, Debug, PartialEq)]
pub struct Operation {
    /// Its name.
    pub name: String,
    /// The type of its argument.
    pub request: String,
    /// The type of its result.
    pub response: String,
}

/// A property of a component.
#[derive(Clone, Debug, PartialEq)]
pub struct PropertyInfo {
    /// Its name.
    pub name: String,
    /// Its value unless set; also tells its type.
    pub default: Value,
    /// The least value.
    pub min: Option<f64>,
    /// The greatest value.
    pub max: Option<f64>,
    /// Its unit.
    pub unit: Option<String>,
    /// What it is for.
    pub doc: String,
}
