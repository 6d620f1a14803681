//! Values, and the elements without structure among them.

use crate::real::Real;
use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

/// An element without structure: an enumeration literal, an abstract constant, an agent, or an
/// element that `extend` took from the reserve. Ordered by declaration, then by creation.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Atom(pub u32);

/// A rule as a value (`<<r_x>>`, `program(a)`); the number is the machine's.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct RuleId(pub u32);

/// What a location holds and a term denotes.
///
/// The representation is fixed, see [`layout`](crate::layout): generated code reads and writes scalars in place.
#[derive(Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[repr(C, u8)]
pub enum Value {
    /// No value.
    #[default]
    Undef,
    /// `true` or `false`.
    Bool(bool),
    /// An element of Integer or of Natural; the type tells them apart.
    Int(i64),
    /// An element of Real.
    Real(Real),
    /// A character.
    Char(char),
    /// An element of an enumeration or of an abstract domain.
    Atom(Atom),
    /// A rule.
    Rule(RuleId),
    /// A text.
    Text(Arc<String>),
    /// A complex number.
    Complex(Arc<(Real, Real)>),
    /// A tuple; at least two components.
    Tuple(Arc<Vec<Value>>),
    /// A sequence.
    Seq(Arc<Vec<Value>>),
    /// A finite set.
    Set(Arc<BTreeSet<Value>>),
    /// A multiset: element to multiplicity, none of them zero.
    Bag(Arc<BTreeMap<Value, usize>>),
    /// A finite map.
    Map(Arc<BTreeMap<Value, Value>>),
}

impl Value {
    /// A text.
    pub fn text(text: impl Into<String>) -> Self {
        Self::Text(Arc::new(text.into()))
    }

    /// A real number.
    pub fn real(number: f64) -> Self {
        Self::Real(Real::new(number))
    }

    /// A tuple of the components, in order.
    pub fn tuple(components: impl IntoIterator<Item = Value>) -> Self {
        Self::Tuple(Arc::new(components.into_iter().collect()))
    }

    /// A sequence of the elements, in order.
    pub fn seq(elements: impl IntoIterator<Item = Value>) -> Self {
        Self::Seq(Arc::new(elements.into_iter().collect()))
    }

    /// The set of the elements.
    pub fn set(elements: impl IntoIterator<Item = Value>) -> Self {
        Self::Set(Arc::new(elements.into_iter().collect()))
    }

    /// The bag of the elements.
    pub fn bag(elements: impl IntoIterator<Item = Value>) -> Self {
        let mut bag = BTreeMap::new();
        for element in elements {
            *bag.entry(element).or_insert(0) += 1;
        }
        Self::Bag(Arc::new(bag))
    }

    /// The map of the pairs; of two pairs with one key the later counts.
    pub fn map(pairs: impl IntoIterator<Item = (Value, Value)>) -> Self {
        Self::Map(Arc::new(pairs.into_iter().collect()))
    }

    /// Whether this is `undef`.
    pub fn is_undef(&self) -> bool {
        matches!(self, Self::Undef)
    }
}
