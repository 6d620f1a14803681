//! The catalogue of a program: components, messages and service interfaces.

use std::fmt;
#[cfg(feature = "ros")]
use std::path::PathBuf;
use std::sync::{Arc, OnceLock};

use asmotion_component::Interface;
use asmotion_component::declaration::{Declaration, OperationDeclaration};
#[cfg(feature = "ros")]
use asmotion_composite::RosFolders;
use asmotion_composite::model::{BridgeKind, BuiltinComponent};
use asmotion_composite::{Catalogue, ComponentFactory, RosMessages};
use asmotion_datum::{Schema, Shape};
#[cfg(feature = "ros")]
use asmotion_diagnostics::Loader;

use crate::feature::without_bridges;

/// Components, messages and service interfaces by name, in order of registration.
///
/// A component brings the types of its ports and the operations of its services and references with it.
#[derive(Clone, Default)]
pub(super) struct BuildCatalogue {
    components: Vec<(String, RegisteredComponent)>,
    messages: Vec<(String, Schema)>,
    interfaces: Vec<(String, Vec<OperationDeclaration>)>,
    protocols: Vec<(String, String)>,
    /// Contradictions between registrations.
    problems: Vec<String>,
}

/// How a component is created, and what it declares.
#[derive(Clone)]
struct RegisteredComponent {
    factory: ComponentFactory,
    /// Known once a component has been created for it.
    declaration: OnceLock<Arc<Declaration>>,
}

impl RegisteredComponent {
    fn new(factory: ComponentFactory) -> Self {
        Self {
            factory,
            declaration: OnceLock::new(),
        }
    }

    fn declaration(&self) -> &Arc<Declaration> {
        self.declaration.get_or_init(|| {
            let mut scratch = Interface::new();
            (self.factory)(&mut scratch);
            Arc::new(scratch.declaration().clone())
        })
    }
}

impl BuildCatalogue {
    /// The catalogue of the standard components.
    pub(super) fn standard() -> Self {
        let mut catalogue = Self::default();
        for (name, schema) in asmotion_components::MESSAGES {
            catalogue
                .messages
                .push(((*name).to_owned(), schema().clone()));
        }
        for (name, operations) in asmotion_components::INTERFACES {
            catalogue
                .interfaces
                .push(((*name).to_owned(), operations()));
        }
        for (name, constructor) in asmotion_components::COMPONENTS {
            catalogue.components.push((
                (*name).to_owned(),
                RegisteredComponent::new(Arc::new(constructor)),
            ));
        }
        for (name, protocol) in asmotion_components::PROTOCOLS {
            catalogue
                .protocols
                .push(((*name).to_owned(), (*protocol).to_owned()));
        }
        catalogue
    }

    /// Adds the protocol of a component, in place of an earlier one.
    pub(super) fn add_protocol(&mut self, component: &str, protocol: &str) {
        self.protocols.retain(|(known, _)| known != component);
        self.protocols
            .push((component.to_owned(), protocol.to_owned()));
    }

    /// Contradictions between registrations, in order.
    pub(super) fn problems(&self) -> &[String] {
        &self.problems
    }

    /// Adds a component, with its messages and interfaces.
    pub(super) fn add_component(&mut self, name: &str, factory: ComponentFactory) {
        if find(&self.components, name).is_some() {
            self.problems.push(format!(
                "component `{name}` is registered twice: give one of them another name"
            ));
            return;
        }
        let mut scratch = Interface::new();
        factory(&mut scratch);
        let problems = scratch.problems().iter();
        self.problems
            .extend(problems.map(|problem| format!("component `{name}`: {problem}")));
        self.add_types(scratch.declaration());
        self.components
            .push((name.to_owned(), RegisteredComponent::new(factory)));
    }

    /// Replaces a component with another implementation that has the same name.
    pub(super) fn replace_component(&mut self, name: &str, factory: ComponentFactory) {
        self.components.retain(|(known, _)| known != name);
        self.add_component(name, factory);
    }

    fn add_types(&mut self, declaration: &Declaration) {
        for port in declaration.inputs.iter().chain(&declaration.outputs) {
            self.add_message(&port.schema);
        }
        let services = declaration.services.iter();
        let services = services.map(|it| (&it.interface, &it.operations));
        let references = declaration.references.iter();
        let references = references.map(|it| (&it.interface, &it.operations));
        for (interface, operations) in services.chain(references) {
            for operation in operations {
                self.add_operation(interface, operation);
            }
        }
    }

    /// Adds the message types in a schema. A type of which only the name is known is not added.
    pub(super) fn add_message(&mut self, schema: &Schema) {
        for part in schema.parts() {
            self.add_message(part);
        }
        let is_record = matches!(schema.shape, Shape::Record(_));
        if !is_record || schema.name.is_empty() {
            return;
        }
        match find(&self.messages, &schema.name) {
            None => self
                .messages
                .push((schema.name.clone().into_owned(), schema.clone())),
            Some(known) => {
                if let Err(difference) = known.compare(schema) {
                    self.problems.push(format!(
                        "message `{}` is registered with different fields: {difference}",
                        schema.name
                    ));
                }
            }
        }
    }

    /// Adds an operation to a service interface, and the messages of the operation.
    pub(super) fn add_operation(&mut self, interface: &str, operation: &OperationDeclaration) {
        self.add_message(&operation.request);
        self.add_message(&operation.response);
        let operation = OperationDeclaration {
            // a provider decides itself what it answers while it is stopped
            while_stopped: false,
            ..operation.clone()
        };
        let known = self.interfaces.iter_mut().find(|(it, _)| it == interface);
        let Some((_, operations)) = known else {
            self.interfaces
                .push((interface.to_owned(), vec![operation]));
            return;
        };
        let known = operations.iter().find(|it| it.name == operation.name);
        let Some(known) = known else {
            operations.push(operation);
            return;
        };
        let request = known.request.compare(&operation.request);
        let response = known.response.compare(&operation.response);
        for (part, result) in [("request", request), ("response", response)] {
            if let Err(difference) = result {
                self.problems.push(format!(
                    "operation `{}` of `{interface}` is registered with different {part} types: {difference}",
                    operation.name
                ));
            }
        }
    }
}

impl Catalogue for BuildCatalogue {
    fn components(&self) -> Vec<String> {
        names(&self.components)
    }

    fn factory(&self, component: &str) -> Option<ComponentFactory> {
        let registered = find(&self.components, component);
        registered.map(|it| Arc::clone(&it.factory))
    }

    fn declaration(&self, component: &str) -> Option<Arc<Declaration>> {
        let registered = find(&self.components, component);
        registered.map(|it| Arc::clone(it.declaration()))
    }

    fn protocol(&self, component: &str) -> Option<String> {
        find(&self.protocols, component).cloned()
    }

    fn has(&self, builtin: BuiltinComponent) -> bool {
        match builtin {
            BuiltinComponent::PortProxy | BuiltinComponent::Remote => true,
            BuiltinComponent::RosBridge => cfg!(feature = "ros"),
            BuiltinComponent::WebMonitor
            | BuiltinComponent::Recorder
            | BuiltinComponent::Replayer
            | BuiltinComponent::Simulator
            | BuiltinComponent::HttpGateway
            | BuiltinComponent::Timer => false,
        }
    }

    #[cfg(feature = "ros")]
    fn ros(&self, kind: BridgeKind) -> Option<&dyn RosMessages> {
        super::ros_messages::of(kind)
    }

    #[cfg(feature = "ros")]
    fn ros_with(
        &self,
        kind: BridgeKind,
        folders: &[PathBuf],
        loader: &dyn Loader,
    ) -> Option<RosFolders> {
        super::ros_messages::with_folders(kind, folders, loader)
    }

    #[cfg(not(feature = "ros"))]
    fn ros(&self, _: BridgeKind) -> Option<&dyn RosMessages> {
        None
    }

    fn way_to_bridges(&self, kind: BridgeKind) -> Option<String> {
        without_bridges(kind).map(|it| it.way())
    }

    fn messages(&self) -> Vec<String> {
        names(&self.messages)
    }

    fn schema(&self, message: &str) -> Option<Schema> {
        let own = find(&self.messages, message).cloned();
        #[cfg(feature = "ros")]
        let own = own.or_else(|| super::ros_messages::schema(message));
        own
    }

    fn interfaces(&self) -> Vec<String> {
        names(&self.interfaces)
    }

    fn operations(&self, interface: &str) -> Option<Vec<OperationDeclaration>> {
        let own = find(&self.interfaces, interface).cloned();
        #[cfg(feature = "ros")]
        let own = own.or_else(|| super::ros_messages::operations(interface));
        own
    }
}

impl fmt::Debug for BuildCatalogue {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("BuildCatalogue")
            .field("components", &names(&self.components))
            .field("messages", &names(&self.messages))
            .field("interfaces", &names(&self.interfaces))
            .finish_non_exhaustive()
    }
}

fn names<T>(table: &[(String, T)]) -> Vec<String> {
    table.iter().map(|(name, _)| name.clone()).collect()
}

fn find<'t, T>(table: &'t [(String, T)], name: &str) -> Option<&'t T> {
    let row = table.iter().find(|(known, _)| known == name);
    row.map(|(_, entry)| entry)
}
