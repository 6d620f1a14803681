//! Interface to the components, message types and service interfaces linked into the executable. The application's
//! crates implement it.

use std::path::PathBuf;
use std::rc::Rc;
use std::sync::Arc;

use asmotion_component::declaration::{Declaration, OperationDeclaration};
use asmotion_component::{Component, Interface};
use asmotion_datum::Schema;
use asmotion_diagnostics::Loader;

use crate::model::{BridgeKind, BuiltinComponent};

/// Creates a component and declares its ports, services and properties on the interface.
pub type Constructor = fn(&mut Interface) -> Box<dyn Component>;

/// Creates the components of one implementation, in any thread. Equal calls declare the same.
pub type ComponentFactory = Arc<dyn Fn(&mut Interface) -> Box<dyn Component> + Send + Sync>;

/// Returns the schema of a message type.
pub type SchemaOf = fn() -> &'static Schema;

/// Returns the operations of a service interface.
pub type OperationsOf = fn() -> Vec<OperationDeclaration>;

/// A message type of ROS.
#[derive(Clone, Debug, PartialEq)]
pub struct RosMessage {
    /// Schema of the messages as components use them: equal in all generations of ROS.
    pub schema: Schema,
    /// Definition as ROS writes it, a line for each field.
    pub definition: String,
}

/// A service or an action of ROS.
#[derive(Clone, Debug, PartialEq)]
pub struct RosOperation {
    /// Schema of the request or the goal, as components use it.
    pub request: Schema,
    /// Schema of the response or the result.
    pub response: Schema,
    /// Schema of the feedback; `None` for a service.
    pub feedback: Option<Schema>,
    /// Definition as ROS writes it, a line for each field.
    pub definition: String,
}

/// Lookup of the services and actions of a generation of ROS.
pub trait RosOperations {
    /// Names of all services and actions.
    fn names(&self) -> Vec<String>;

    /// Returns a service or an action, such as `nav_msgs/GetPlan`; `None` if it is unknown.
    fn find(&self, name: &str) -> Option<RosOperation>;

    /// Returns the operations of the service interface with the name of a service or an action; `None` if it is unknown.
    fn interface(&self, _name: &str) -> Option<Vec<OperationDeclaration>> {
        None
    }
}

/// Returns the message types of ROS for bridges of a kind; `None` if the executable cannot connect such bridges.
pub type RosMessagesOf = fn(BridgeKind) -> Option<&'static dyn RosMessages>;

/// Lookup of the message types of a generation of ROS.
pub trait RosMessages {
    /// Names of all message types.
    fn names(&self) -> Vec<String>;

    /// Returns a message type, such as `nav_msgs/Path`; `None` if it is unknown.
    fn find(&self, name: &str) -> Option<RosMessage>;

    /// Returns the services and actions; `None` if the executable connects topics only.
    fn operations(&self) -> Option<&dyn RosOperations> {
        None
    }

    /// Returns why a message, service or action that has a definition cannot be used, such as a missing definition of a field.
    fn problem(&self, _name: &str) -> Option<String> {
        None
    }
}

/// The message types of a generation of ROS, with those that folders define.
pub struct RosFolders {
    /// All types. A wrong definition is left out.
    pub messages: Rc<dyn RosMessages>,
    /// What is wrong with the folders.
    pub problems: Vec<RosFolderProblem>,
}

/// A folder of definitions cannot be read, or a definition in it is wrong.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct RosFolderProblem {
    /// Position of the folder.
    pub folder: usize,
    /// Path of the file with the definition; `None` if the folder itself is the problem.
    pub file: Option<String>,
    /// Line in the file, from 1; `None` if the problem is at none.
    pub line: Option<usize>,
    /// Cause.
    pub reason: String,
}

/// Lookup of the components, messages and service interfaces available in an executable.
pub trait Catalogue {
    /// Names accepted by `implementation.rust`.
    fn components(&self) -> Vec<String>;

    /// Returns the factory of the component; `None` if the executable does not contain it.
    fn factory(&self, component: &str) -> Option<ComponentFactory>;

    /// Returns the ports, services, references and properties that the component declares; `None` if it is unknown. A composite asks
    /// once for each instance and each wire, so a catalogue whose components are costly to create keeps it.
    fn declaration(&self, component: &str) -> Option<Arc<Declaration>> {
        let mut scratch = Interface::new();
        self.factory(component)?(&mut scratch);
        Some(Arc::new(scratch.declaration().clone()))
    }

    /// Returns the text of the component's protocol: a specification of what it sends, depending on what it receives.
    /// `None` if it has none, or is unknown.
    fn protocol(&self, _component: &str) -> Option<String> {
        None
    }

    /// Returns whether the executable contains the built-in component.
    fn has(&self, builtin: BuiltinComponent) -> bool;

    /// Returns the message types of ROS for bridges of a kind; `None` if the executable cannot connect such bridges.
    fn ros(&self, kind: BridgeKind) -> Option<&dyn RosMessages>;

    /// Returns the message types of ROS for bridges of a kind with the definitions in folders, whose files the loader reads;
    /// `None` if the executable cannot connect such bridges.
    fn ros_with(
        &self,
        _kind: BridgeKind,
        _folders: &[PathBuf],
        _loader: &dyn Loader,
    ) -> Option<RosFolders> {
        None
    }

    /// Returns the way to an executable that connects bridges of a kind; `None` if this one does, or none can.
    fn way_to_bridges(&self, kind: BridgeKind) -> Option<String>;

    /// Names of all message types.
    fn messages(&self) -> Vec<String>;

    /// Returns the schema of a message type; `None` if it is unknown.
    fn schema(&self, message: &str) -> Option<Schema>;

    /// Names of all service interfaces.
    fn interfaces(&self) -> Vec<String>;

    /// Returns the operations of a service interface; `None` if it is unknown.
    fn operations(&self, interface: &str) -> Option<Vec<OperationDeclaration>>;
}

/// A catalogue backed by static tables. With an empty table the declarations in the composite are not verified.
#[derive(Clone, Copy, Debug, Default)]
pub struct Tables {
    /// Component constructors by implementation name.
    pub components: &'static [(&'static str, Constructor)],
    /// Schemas by message type.
    pub messages: &'static [(&'static str, SchemaOf)],
    /// Operations by service interface.
    pub interfaces: &'static [(&'static str, OperationsOf)],
    /// Built-in components contained in the executable.
    pub builtins: &'static [BuiltinComponent],
    /// Message types of ROS for bridges of a kind; `None` if the executable connects no bridges.
    pub ros: Option<RosMessagesOf>,
}

impl Tables {
    /// A catalogue without any entry.
    pub const EMPTY: Self = Self {
        components: &[],
        messages: &[],
        interfaces: &[],
        builtins: &[],
        ros: None,
    };
}

impl Catalogue for Tables {
    fn components(&self) -> Vec<String> {
        self.components
            .iter()
            .map(|(name, _)| (*name).to_owned())
            .collect()
    }

    fn factory(&self, component: &str) -> Option<ComponentFactory> {
        row(self.components, component).map(|constructor| Arc::new(constructor) as ComponentFactory)
    }

    fn has(&self, builtin: BuiltinComponent) -> bool {
        self.builtins.contains(&builtin)
    }

    fn ros(&self, kind: BridgeKind) -> Option<&dyn RosMessages> {
        Some(self.ros?(kind)? as &dyn RosMessages)
    }

    fn way_to_bridges(&self, _: BridgeKind) -> Option<String> {
        None
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

    fn interfaces(&self) -> Vec<String> {
        self.interfaces
            .iter()
            .map(|(name, _)| (*name).to_owned())
            .collect()
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
