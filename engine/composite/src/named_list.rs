//! A list with an index by name.

use std::collections::BTreeMap;
use std::fmt;
use std::ops::Deref;

/// A component, as far as a [`NamedList`] looks at it.
pub trait HasName {
    /// Returns the name, which does not change.
    fn name(&self) -> &str;
}

/// Components in file order, with an index by name: checking, planning and starting a system look up each component, of which there
/// may be thousands.
#[derive(Clone, PartialEq)]
pub struct NamedList<T> {
    items: Vec<T>,
    /// Positions by name; of several components with one name, that of the first.
    positions: BTreeMap<String, usize>,
}

impl<T: HasName> NamedList<T> {
    /// Appends a component.
    pub fn push(&mut self, item: T) {
        let (name, position) = (item.name().to_owned(), self.items.len());
        self.positions.entry(name).or_insert(position);
        self.items.push(item);
    }
}

impl<T> NamedList<T> {
    /// Returns the position of the component with this name.
    pub fn position(&self, name: &str) -> Option<usize> {
        self.positions.get(name).copied()
    }

    /// Returns the component with this name.
    pub fn named(&self, name: &str) -> Option<&T> {
        self.items.get(self.position(name)?)
    }

    /// Returns the component at a position to change what is not its name.
    pub fn at_mut(&mut self, position: usize) -> Option<&mut T> {
        self.items.get_mut(position)
    }

    /// Returns the components without the index.
    pub(crate) fn into_items(self) -> Vec<T> {
        self.items
    }
}

impl<T> Default for NamedList<T> {
    fn default() -> Self {
        Self {
            items: Vec::new(),
            positions: BTreeMap::new(),
        }
    }
}

/// The components as a list.
impl<T: fmt::Debug> fmt::Debug for NamedList<T> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.items.fmt(f)
    }
}

impl<T> Deref for NamedList<T> {
    type Target = [T];

    fn deref(&self) -> &[T] {
        &self.items
    }
}

impl<'l, T> IntoIterator for &'l NamedList<T> {
    type Item = &'l T;
    type IntoIter = std::slice::Iter<'l, T>;

    fn into_iter(self) -> Self::IntoIter {
        self.items.iter()
    }
}
