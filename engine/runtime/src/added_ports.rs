//! Ports that a component gets while it runs.

use asmotion_component::declaration::PortDeclaration;
use asmotion_port::{AnyInput, AnyOutput};

/// Ports that follow those of a running component.
#[derive(Default)]
pub(crate) struct AddedPorts {
    pub inputs: Vec<Box<dyn AnyInput>>,
    pub outputs: Vec<Box<dyn AnyOutput>>,
    pub declared_inputs: Vec<PortDeclaration>,
    pub declared_outputs: Vec<PortDeclaration>,
}

impl AddedPorts {
    pub(crate) fn is_empty(&self) -> bool {
        self.inputs.is_empty() && self.outputs.is_empty()
    }
}
