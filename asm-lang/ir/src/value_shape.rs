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

impl ValueShape {
    /// Returns the domain of the values in the notation of the language; `declared` returns the text of a declared domain.
    pub fn domain_text(&self, declared: &dyn Fn(DomainId) -> String) -> String {
        let inner = |shape: &Self| shape.domain_text(declared);
        match self {
            Self::Bool => "Boolean".to_owned(),
            Self::Int => "Integer".to_owned(),
            Self::Natural => "Natural".to_owned(),
            Self::Real => "Real".to_owned(),
            Self::Char => "Char".to_owned(),
            Self::Text => "String".to_owned(),
            Self::Complex => "Complex".to_owned(),
            Self::Rule => "Rule".to_owned(),
            Self::Any => "Any".to_owned(),
            Self::Domain(domain) => declared(*domain),
            Self::Tuple(items) => {
                let items: Vec<String> = items.iter().map(inner).collect();
                format!("Prod({})", items.join(", "))
            }
            Self::Seq(item) => format!("Seq({})", inner(item)),
            Self::Set(item) => format!("Powerset({})", inner(item)),
            Self::Bag(item) => format!("Bag({})", inner(item)),
            Self::Map(key, content) => format!("Map({}, {})", inner(key), inner(content)),
        }
    }
}
