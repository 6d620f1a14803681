//! The active components of a composite, with an index by name.

use std::collections::BTreeMap;
use std::ops::Deref;

use super::scene::CheckedComponent;

/// Components in file order. Each end of a connection or a wire is looked up, of which there may be thousands.
#[derive(Default)]
pub(crate) struct PartList<'s> {
    parts: Vec<CheckedComponent<'s>>,
    positions: BTreeMap<&'s str, usize>,
}

impl<'s> PartList<'s> {
    /// Appends a component.
    pub(super) fn push(&mut self, part: CheckedComponent<'s>) {
        let name = part.component.name.value.as_str();
        let position = self.parts.len();
        self.positions.entry(name).or_insert(position);
        self.parts.push(part);
    }

    /// Returns the component of this name.
    pub(crate) fn named(&self, name: &str) -> Option<&CheckedComponent<'s>> {
        self.parts.get(*self.positions.get(name)?)
    }

    /// Returns the component at a position to change its ports and services.
    pub(super) fn at_mut(&mut self, position: usize) -> Option<&mut CheckedComponent<'s>> {
        self.parts.get_mut(position)
    }

    /// Returns the components as a list.
    pub(super) fn into_parts(self) -> Vec<CheckedComponent<'s>> {
        self.parts
    }
}

impl<'s> Deref for PartList<'s> {
    type Target = [CheckedComponent<'s>];

    fn deref(&self) -> &[CheckedComponent<'s>] {
        &self.parts
    }
}

impl<'p, 's> IntoIterator for &'p PartList<'s> {
    type Item = &'p CheckedComponent<'s>;
    type IntoIter = std::slice::Iter<'p, CheckedComponent<'s>>;

    fn into_iter(self) -> Self::IntoIter {
        self.parts.iter()
    }
}
