//! Types of services and actions, by name.

use asmotion_component::declaration::OperationDeclaration;
use asmotion_datum::Schema;
use asmotion_ros_interface::{
    Catalogue, DefinitionError, DefinitionProblem, Distribution, InterfaceKind, InterfaceName,
};

use crate::operation::OperationSchemas;

/// The operation of an interface that is a service or an action of ROS.
pub const CALL: &str = "call";
/// The operation of such an interface of an action that cancels the goals.
pub const CANCEL: &str = "cancel";

/// A service or an action.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum OperationKind {
    /// Request and response.
    Service,
    /// Goal, feedback and result.
    Action,
}

/// The type of a service or an action.
#[derive(Clone, Debug, PartialEq)]
pub struct OperationType {
    /// Name.
    pub name: InterfaceName,
    /// What it is.
    pub kind: OperationKind,
}

impl OperationType {
    /// Finds a type by its name, such as `nav_msgs/GetPlan`, or `nav_msgs/action/GetMap` where a service has the same short
    /// name. `None` if it is not defined.
    pub fn find(catalogue: &Catalogue, text: &str) -> Option<Self> {
        let written: InterfaceName = text.parse().ok()?;
        let named = |kind| InterfaceName::new(written.package(), kind, written.name()).ok();
        let service = || {
            let name = named(InterfaceKind::Service)?;
            let is_defined = catalogue.interface(&name).is_ok();
            is_defined.then_some((name, OperationKind::Service))
        };
        let action = || {
            let name = named(InterfaceKind::Action)?;
            let is_defined = Self::action_parts(catalogue, &name).is_ok();
            is_defined.then_some((name, OperationKind::Action))
        };
        let (name, kind) = match (written.kind(), text.matches('/').count()) {
            (InterfaceKind::Service, _) => service(),
            (InterfaceKind::Action, _) => action(),
            (InterfaceKind::Message, 1) => service().or_else(action),
            (InterfaceKind::Message, _) => None,
        }?;
        Some(Self { name, kind })
    }

    /// Finds a type, as [`find`](Self::find).
    ///
    /// # Errors
    /// It is not defined; the text says so.
    pub fn known(catalogue: &Catalogue, text: &str) -> Result<Self, String> {
        let found = Self::find(catalogue, text);
        found.ok_or_else(|| format!("`{text}` is neither a service nor an action that is defined"))
    }

    /// The names of all types of a catalogue: short, except where a service and an action have the same.
    pub fn names(catalogue: &Catalogue) -> Vec<String> {
        let mut names = Vec::new();
        for (name, _) in catalogue.interfaces() {
            match name.kind() {
                InterfaceKind::Service | InterfaceKind::Action => names.push(name.short()),
                InterfaceKind::Message => {
                    let action = name.name().strip_suffix("ActionGoal");
                    names.extend(action.map(|action| format!("{}/{action}", name.package())));
                }
            }
        }
        names.sort();
        names.dedup();
        names
    }

    /// The schemas, with the fields that only this generation of ROS has.
    ///
    /// # Errors
    /// A definition is missing, or a message contains itself.
    pub fn schemas(&self, catalogue: &Catalogue) -> Result<OperationSchemas, DefinitionError> {
        match self.kind {
            OperationKind::Service => {
                let mut parts = catalogue.schemas(&self.name)?.into_iter();
                let undefined = || undefined(&self.name);
                Ok(OperationSchemas {
                    request: parts.next().ok_or_else(undefined)?,
                    response: parts.next().ok_or_else(undefined)?,
                    feedback: None,
                })
            }
            OperationKind::Action => Self::action_parts(catalogue, &self.name),
        }
    }

    /// The schemas as components use them, equal in all generations of ROS.
    ///
    /// # Errors
    /// As [`schemas`](Self::schemas).
    pub fn common_schemas(
        &self,
        catalogue: &Catalogue,
    ) -> Result<OperationSchemas, DefinitionError> {
        let OperationSchemas {
            request,
            response,
            feedback,
        } = self.schemas(catalogue)?;
        Ok(OperationSchemas {
            request: asmotion_ros_interface::common(request),
            response: asmotion_ros_interface::common(response),
            feedback: feedback.map(asmotion_ros_interface::common),
        })
    }

    /// The operations of an interface of this name: [`CALL`], and [`CANCEL`] for an action.
    ///
    /// # Errors
    /// As [`schemas`](Self::schemas).
    pub fn operations(
        &self,
        catalogue: &Catalogue,
    ) -> Result<Vec<OperationDeclaration>, DefinitionError> {
        let schemas = self.common_schemas(catalogue)?;
        let operation = |name: &str, request, response| OperationDeclaration {
            name: name.to_owned(),
            request,
            response,
            while_stopped: false,
        };
        let mut operations = vec![operation(CALL, schemas.request, schemas.response)];
        if self.kind == OperationKind::Action {
            let nothing = || Schema::record("std_msgs/Empty", Vec::new());
            operations.push(operation(CANCEL, nothing(), nothing()));
        }
        Ok(operations)
    }

    /// The definition as ROS writes it.
    ///
    /// # Errors
    /// A definition is missing.
    pub fn definition(&self, catalogue: &Catalogue) -> Result<String, DefinitionError> {
        if let Ok(interface) = catalogue.interface(&self.name) {
            return Ok(interface.to_string());
        }
        let parts = ["Goal", "Result", "Feedback"];
        let texts = parts.into_iter().map(|suffix| {
            let name = message(&self.name, suffix)?;
            Ok(catalogue.interface(&name)?.to_string())
        });
        let texts: Vec<String> = texts.collect::<Result<_, DefinitionError>>()?;
        Ok(texts.join("---\n"))
    }

    /// Goal, result and feedback of an action: its own structures, or the messages that ROS 1 makes of them.
    fn action_parts(
        catalogue: &Catalogue,
        name: &InterfaceName,
    ) -> Result<OperationSchemas, DefinitionError> {
        if catalogue.distribution() == Distribution::Ros1 {
            // what a client needs
            catalogue.interface(&message(name, "ActionGoal")?)?;
            let part = |suffix| catalogue.schema(&message(name, suffix)?);
            return Ok(OperationSchemas {
                request: part("Goal")?,
                response: part("Result")?,
                feedback: Some(part("Feedback")?),
            });
        }
        let mut parts = catalogue.schemas(name)?.into_iter();
        let mut next = || parts.next().ok_or_else(|| undefined(name));
        Ok(OperationSchemas {
            request: next()?,
            response: next()?,
            feedback: Some(next()?),
        })
    }
}

/// A message that ROS 1 makes of an action.
fn message(of: &InterfaceName, suffix: &str) -> Result<InterfaceName, DefinitionError> {
    let name = format!("{}{suffix}", of.name());
    let name = InterfaceName::new(of.package(), InterfaceKind::Message, &name);
    name.map_err(|_| undefined(of))
}

fn undefined(name: &InterfaceName) -> DefinitionError {
    DefinitionError {
        interface: name.clone(),
        line: None,
        problem: DefinitionProblem::Undefined,
    }
}
