//! Shapes: the structure of values, without the names of their types.

use crate::id::DomainId;
use asmotion_value::Value;

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

    /// Returns the first part of a value that is not an element of its domain, with that domain: the value itself, or a value
    /// within a tuple or collection. `undef` belongs to every domain.
    pub fn outsider<'v>(
        &self,
        value: &'v Value,
        is_element: &dyn Fn(DomainId, &Value) -> bool,
    ) -> Option<(DomainId, &'v Value)> {
        let part = |shape: &Self, item: &'v Value| shape.outsider(item, is_element);
        match (self, value) {
            (_, Value::Undef) => None,
            (Self::Domain(domain), value) => {
                (!is_element(*domain, value)).then_some((*domain, value))
            }
            (Self::Tuple(shapes), Value::Tuple(items)) => {
                let mut pairs = shapes.iter().zip(items.iter());
                pairs.find_map(|(shape, item)| part(shape, item))
            }
            (Self::Seq(shape), Value::Seq(items)) => {
                items.iter().find_map(|item| part(shape, item))
            }
            (Self::Set(shape), Value::Set(items)) => {
                items.iter().find_map(|item| part(shape, item))
            }
            (Self::Bag(shape), Value::Bag(items)) => {
                items.keys().find_map(|item| part(shape, item))
            }
            (Self::Map(keys, values), Value::Map(pairs)) => pairs
                .iter()
                .find_map(|(key, value)| part(keys, key).or_else(|| part(values, value))),
            // values of other kinds are distinguished by static types
            _ => None,
        }
    }
}
