//! Components of a plan.

use std::sync::Arc;

use crate::plan::{Implementation, Lifecycle, Pace, PropertyValues};
use asmotion_composite::HasName;
use asmotion_composite::model::PlannedSpecialKeys;
use asmotion_coordinator::Binding;
use asmotion_program::ProgramDeclaration;

/// A component of a plan.
#[derive(Clone, Debug, PartialEq)]
pub struct Component {
    /// Name qualified by the enclosing composites, such as `Driver/youBotDriver`.
    pub name: String,
    /// Unique name by which tools can address the component, too.
    pub id: String,
    /// Implementation to run.
    pub implementation: Implementation,
    /// Schedule of its cycles.
    pub pace: Pace,
    /// Automatic lifecycle transitions.
    pub lifecycle: Lifecycle,
    /// Input ports in declaration order.
    pub inputs: Vec<Port>,
    /// Output ports in declaration order.
    pub outputs: Vec<Port>,
    /// Provided services.
    pub services: Vec<Service>,
    /// Required references.
    pub references: Vec<Service>,
    /// Property values set by the composite.
    pub properties: PropertyValues,
    /// `bind` of an ASM component, which instances of one component share if they differ in names only; `None` for other
    /// implementations.
    pub binding: Option<Arc<Binding>>,
    /// `map` and `notify` compiled for the bridge; `None` for components other than port-proxies.
    pub bridge: Option<asmotion_bridge::ProxySettings>,
    /// Declaration of the program that implements the component; `None` for other implementations, and if the program was
    /// not asked.
    pub program: Option<ProgramDeclaration>,
    /// Keys that only its kind of implementation has.
    pub special: PlannedSpecialKeys,
}

impl HasName for Component {
    fn name(&self) -> &str {
        &self.name
    }
}

/// A port of a component.
#[derive(Clone, Debug, PartialEq)]
pub struct Port {
    /// Name in the component.
    pub name: String,
    /// Message type name; empty if unknown.
    pub kind: String,
    /// Topic of the port; `None` if it is only connected directly.
    pub topic: Option<String>,
}

/// A service or a reference.
#[derive(Clone, Debug, PartialEq)]
pub struct Service {
    /// Name in the component.
    pub name: String,
    /// Interface name.
    pub interface: String,
}
