//! Shapes: the structure of values, without the names of their types.

use crate::id::DomainId;

/// The structure of a type's values, as needed to read inputs and to enumerate domains.
#[derive(Clone, Debug, PartialEq)]
pub enum ValueShape {
    /// Truth values.
    Bool,
    /// Integers.
    Int,
    /// Non-negative integers.
    Natural,
    /// Real numbers, as 64-bit floats.
    Real,
    /// Characters.
    Char,
    /// Character strings.
    Text,
    /// Complex numbers.
    Complex,
    /// Rules as values.
    Rule,
    /// The elements of a domain.
    Domain(DomainId),
    /// Tuples, by their components.
    Tuple(Vec<ValueShape>),
    /// Sequences of one element shape.
    Seq(Box<ValueShape>),
    /// Sets of one element shape.
    Set(Box<ValueShape>),
    /// Bags of one element shape.
    Bag(Box<ValueShape>),
    /// Maps, by the shapes of key and value.
    Map(Box<ValueShape>, Box<ValueShape>),
    /// Values of any shape.
    Any,
}
