//! What this build has: components, messages, operations. The robot's crates fill it; this crate
//! only asks.

use asmotion_component::declaration::{Declaration, OperationDeclaration};
use asmotion_component::{Component, Interface};
use asmotion_datum::Schema;

use crate::model::BuiltinComponent;

/// Makes a component: declares its ports, services and properties on the interface.
pub type Constructor = fn(&mut Interface) -> Box<dyn Component>;

/// Gives the schema of a message.
pub type SchemaOf = fn() -> &'static Schema;

/// Gives the operations of an interface.
pub type OperationsOf = fn() -> Vec<OperationDeclaration>;

/// What this build has.
pub trait Catalogue {
    /// The names under `implementation.rust`.
    fn components(&self) -> Vec<String>;

    /// Makes the component of this name.
    fn constructor(&self, component: &str) -> Option<Constructor>;

    /// What the component of this name declares.
    fn declaration(&self, component: &str) -> Option<Declaration> {
        let mut scratch = Interface::new();
        self.constructor(component)?(&mut scratch);
        Some(scratch.declaration().clone())
    }

    /// Whether this built-in is in this build.
    fn has(&self, builtin: BuiltinComponent) -> bool;

    /// The names of all message types.
    fn messages(&self) -> Vec<String>;

    /// What a message looks like.
    fn schema(&self, message: &str) -> Option<Schema>;

    /// The operations of an interface; `None` where the interface is not known.
    fn operations(&self, interface: &str) -> Option<Vec<OperationDeclaration>>;
}

/// A build as tables of names. An empty one has nothing: what a composite says of its components
/// is then believed.
#[derive(Clone, Copy, Debug, Default)]
pub struct Tables {
    /// Components by the name a composite gives them.
    pub components: &'static [(&'static str, Constructor)],
    /// Message types.
    pub messages: &'static [(&'static str, SchemaOf)],
    /// Interfaces of services.
    pub interfaces: &'static [(&'static str, OperationsOf)],
    /// Built-ins.
    pub builtins: &'static [BuiltinComponent],
}

impl Tables {
    /// A build that has nothing.
    pub const EMPTY: Self = Self {
        components: &[],
        messages: &[],
        interfaces: &[],
        builtins: &[],
    };
}

impl Catalogue for Tables {
    fn components(&self) -> Vec<String> {
        self.components
            .iter()
            .map(|(name, _)| (*name).to_owned())
            .collect()
    }

    fn constructor(&self, component: &str) -> Option<Constructor> {
        row(self.components, component)
    }

    fn has(&self, builtin: BuiltinComponent) -> bool {
        self.builtins.contains(&builtin)
    }

    fn messages(&self) -> Vec<String> {
        self.messages
            .iter()
            .map(|(name, _)| (*name).to_owned())
            .collect()
    }

    fn schema(&self, message: &str) -> Option<Schema> {
        row(self.messages, message).map(|schema| schema().clone())
    }

    fn operations(&self, interface: &str) -> Option<Vec<OperationDeclaration>> {
        row(self.interfaces, interface).map(|operations| operations())
    }
}

fn row<T: Copy>(table: &[(&str, T)], name: &str) -> Option<T> {
    table
        .iter()
        .find(|(known, _)| *known == name)
        .map(|(_, found)| *found)
}
