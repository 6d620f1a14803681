//! The components of a plan.

use std::collections::BTreeMap;
use std::fmt;
use std::ops::Deref;

use crate::component::Component;

/// Components in file order, with an index by name: planning and starting a system look up each component, of which there may be
/// thousands.
#[derive(Clone, Default, PartialEq)]
pub struct ComponentList {
    components: Vec<Component>,
    /// Positions by qualified name; of several components with one name, that of the first.
    positions: BTreeMap<String, usize>,
}

impl ComponentList {
    /// Appends a component.
    pub(crate) fn push(&mut self, component: Component) {
        let position = self.components.len();
        let name = component.name.clone();
        self.positions.entry(name).or_insert(position);
        self.components.push(component);
    }

    /// Returns the position of the component with this qualified name.
    pub fn position(&self, name: &str) -> Option<usize> {
        self.positions.get(name).copied()
    }

    /// Returns the component at a position to change what is not its name.
    pub(crate) fn at_mut(&mut self, position: usize) -> Option<&mut Component> {
        self.components.get_mut(position)
    }
}

/// The components as a list.
impl fmt::Debug for ComponentList {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.components.fmt(f)
    }
}

impl Deref for ComponentList {
    type Target = [Component];

    fn deref(&self) -> &[Component] {
        &self.components
    }
}

impl<'c> IntoIterator for &'c ComponentList {
    type Item = &'c Component;
    type IntoIter = std::slice::Iter<'c, Component>;

    fn into_iter(self) -> Self::IntoIter {
        self.components.iter()
    }
}
