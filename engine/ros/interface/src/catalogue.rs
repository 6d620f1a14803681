//! All definitions of a distribution.

use std::collections::BTreeMap;

use crate::definition::{Element, Interface, Structure};
use crate::distribution::Distribution;
use crate::error::{DefinitionError, DefinitionProblem};
use crate::name::InterfaceName;
use crate::parse;

/// The definitions of one distribution, by name.
#[derive(Debug, Clone, PartialEq)]
pub struct Catalogue {
    distribution: Distribution,
    interfaces: BTreeMap<InterfaceName, Interface>,
}

impl Catalogue {
    /// A catalogue without definitions.
    pub fn empty(distribution: Distribution) -> Self {
        Self {
            distribution,
            interfaces: BTreeMap::new(),
        }
    }

    /// The distribution.
    pub fn distribution(&self) -> Distribution {
        self.distribution
    }

    /// Adds a definition, or replaces the one of this name. Names in it that are not defined yet may be added later.
    ///
    /// # Errors
    /// The text is not a definition.
    pub fn define(&mut self, name: InterfaceName, text: &str) -> Result<(), DefinitionError> {
        let interface = parse::interface(&name, text, self.distribution)?;
        self.interfaces.insert(name, interface);
        Ok(())
    }

    /// The definition of an interface.
    ///
    /// # Errors
    /// [`DefinitionProblem::Undefined`].
    pub fn interface(&self, name: &InterfaceName) -> Result<&Interface, DefinitionError> {
        self.interfaces.get(name).ok_or_else(|| DefinitionError {
            interface: name.clone(),
            line: None,
            problem: DefinitionProblem::Undefined,
        })
    }

    /// All definitions, by name.
    pub fn interfaces(&self) -> impl Iterator<Item = (&InterfaceName, &Interface)> {
        self.interfaces.iter()
    }

    /// The structure of a message.
    ///
    /// # Errors
    /// The message is not defined.
    pub(crate) fn message(&self, name: &InterfaceName) -> Result<&Structure, DefinitionError> {
        match self.interface(name)? {
            Interface::Message(structure) => Ok(structure),
            Interface::Service { .. } | Interface::Action { .. } => Err(DefinitionError {
                interface: name.clone(),
                line: None,
                problem: DefinitionProblem::Undefined,
            }),
        }
    }

    /// The messages that an interface contains, also in other messages, each once, in the order in which they are first
    /// needed.
    ///
    /// # Errors
    /// A message is not defined, or contains itself.
    pub fn contained<'a>(
        &'a self,
        name: &InterfaceName,
    ) -> Result<Vec<&'a InterfaceName>, DefinitionError> {
        let mut all = Vec::new();
        for structure in self.interface(name)?.structures() {
            let own = self.interfaces.get_key_value(name);
            let mut open = own.into_iter().map(|(name, _)| name).collect();
            self.collect(name, structure, &mut open, &mut all)?;
        }
        Ok(all)
    }

    /// The definition of a message with those of all messages in it, as ROS 1 puts it into the header of a connection and into
    /// a bag: separated by lines of `=`, with `MSG: NAME` before each but the first.
    ///
    /// # Errors
    /// A definition is missing, or a message contains itself.
    pub fn full_text(&self, name: &InterfaceName) -> Result<String, DefinitionError> {
        let mut text = self.interface(name)?.to_string();
        for inner in self.contained(name)? {
            let short = inner.short();
            let line = "=".repeat(80);
            text.push_str(&format!("\n{line}\nMSG: {short}\n{}", self.message(inner)?));
        }
        Ok(text)
    }

    /// Adds the messages in a structure of `owner`. `open` are the messages that contain the structure.
    fn collect<'a>(
        &'a self,
        owner: &InterfaceName,
        structure: &'a Structure,
        open: &mut Vec<&'a InterfaceName>,
        all: &mut Vec<&'a InterfaceName>,
    ) -> Result<(), DefinitionError> {
        let error = |problem| DefinitionError {
            interface: owner.clone(),
            line: None,
            problem,
        };
        for field in &structure.fields {
            let Element::Message(name) = &field.of.element else {
                continue;
            };
            if open.contains(&name) {
                return Err(error(DefinitionProblem::Recursive(name.clone())));
            }
            if all.contains(&name) {
                continue;
            }
            let Ok(inner) = self.message(name) else {
                return Err(error(DefinitionProblem::UndefinedField(name.clone())));
            };
            all.push(name);
            open.push(name);
            self.collect(name, inner, open, all)?;
            open.pop();
        }
        Ok(())
    }
}
