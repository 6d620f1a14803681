//! Ports and references that a component gets while it runs.

use asmotion_component::Declaration;
use asmotion_component::declaration::{PortDeclaration, ReferenceDeclaration};
use asmotion_port::{AnyInput, AnyOutput};

/// Ports that follow those of a running component, and its references afterwards.
#[derive(Default)]
pub(crate) struct AddedPorts {
    pub inputs: Vec<Box<dyn AnyInput>>,
    pub outputs: Vec<Box<dyn AnyOutput>>,
    pub declared_inputs: Vec<PortDeclaration>,
    pub declared_outputs: Vec<PortDeclaration>,
    /// All references, of which those of the running component come first, each with its operations first; empty if none is new
    /// and none has further operations.
    pub references: Vec<ReferenceDeclaration>,
}

impl AddedPorts {
    pub(crate) fn is_empty(&self) -> bool {
        self.inputs.is_empty() && self.outputs.is_empty() && self.references.is_empty()
    }
}

/// What a component declared before it got further ports.
pub(crate) struct FormerPorts {
    pub inputs: usize,
    pub outputs: usize,
    pub references: Vec<ReferenceDeclaration>,
}

impl FormerPorts {
    pub(crate) fn of(declaration: &Declaration) -> Self {
        Self {
            inputs: declaration.inputs.len(),
            outputs: declaration.outputs.len(),
            references: declaration.references.clone(),
        }
    }

    /// Removes from a declaration what has been added since.
    pub(crate) fn restore(&self, declaration: &mut Declaration) {
        declaration.inputs.truncate(self.inputs);
        declaration.outputs.truncate(self.outputs);
        declaration.references.clone_from(&self.references);
    }
}
