//! Values, including atoms and rules.

use crate::real::Real;
use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

/// An element without structure: an enumeration literal, an abstract constant, an agent, or an
/// element that `extend` created from the reserve. Ordered by declaration, then by creation.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Atom(pub u32);

/// A rule as a value (`<<r_x>>`, `program(a)`): its index in the program.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct RuleId(pub u32);

/// The value of a location or a term.
///
/// The representation is fixed (see [`layout`](crate::layout)), because generated code accesses
/// scalars in place.
#[derive(Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[repr(C, u8)]
pub enum Value {
    /// The undefined value, default of every location.
    #[default]
    Undef,
    /// A truth value.
    Bool(bool),
    /// An element of Integer or Natural, which static types distinguish.
    Int(i64),
    /// An element of Real, a 64-bit float.
    Real(Real),
    /// An element of Char, a Unicode scalar value.
    Char(char),
    /// An element of an enumeration or of an abstract domain.
    Atom(Atom),
    /// An element of Rule.
    Rule(RuleId),
    /// An element of String.
    Text(Arc<String>),
    /// An element of Complex: real and imaginary part.
    Complex(Arc<(Real, Real)>),
    /// A tuple of at least two components.
    Tuple(Arc<Vec<Value>>),
    /// A finite sequence.
    Seq(Arc<Vec<Value>>),
    /// A finite set.
    Set(Arc<BTreeSet<Value>>),
    /// A finite multiset: elements with their multiplicities, which are greater than 0.
    Bag(Arc<BTreeMap<Value, usize>>),
    /// A finite map.
    Map(Arc<BTreeMap<Value, Value>>),
}

impl Value {
    /// Creates a string.
    pub fn text(text: impl Into<String>) -> Self {
        Self::Text(Arc::new(text.into()))
    }

    /// Creates a real number.
    pub fn real(number: f64) -> Self {
        Self::Real(Real::new(number))
    }

    /// Creates a tuple of the components.
    pub fn tuple(components: impl IntoIterator<Item = Value>) -> Self {
        Self::Tuple(Arc::new(components.into_iter().collect()))
    }

    /// Creates a sequence of the elements.
    pub fn seq(elements: impl IntoIterator<Item = Value>) -> Self {
        Self::Seq(Arc::new(elements.into_iter().collect()))
    }

    /// Creates the set of the elements.
    pub fn set(elements: impl IntoIterator<Item = Value>) -> Self {
        Self::Set(Arc::new(elements.into_iter().collect()))
    }

    /// Creates the bag of the elements.
    pub fn bag(elements: impl IntoIterator<Item = Value>) -> Self {
        let mut bag = BTreeMap::new();
        for element in elements {
            *bag.entry(element).or_insert(0) += 1;
        }
        Self::Bag(Arc::new(bag))
    }

    /// Creates the map of the pairs. Of several pairs with one key, the last prevails.
    pub fn map(pairs: impl IntoIterator<Item = (Value, Value)>) -> Self {
        Self::Map(Arc::new(pairs.into_iter().collect()))
    }

    /// Returns `true` for `undef`.
    pub fn is_undef(&self) -> bool {
        matches!(self, Self::Undef)
    }
}
