//! Values with their names, independent of a machine.

use asmotion_lang::Value;
use asmotion_lang::machine::Naming;

/// A value whose elements of enumerations and abstract domains are given by name.
#[derive(Clone, Debug, PartialEq)]
pub enum ExportedValue {
    /// The undefined value.
    Undef,
    /// A truth value.
    Bool(bool),
    /// An integer.
    Int(i64),
    /// A string, a character, the name of an element or rule, or a real or complex number.
    Text(String),
    /// A tuple.
    Tuple(Vec<ExportedValue>),
    /// A sequence.
    List(Vec<ExportedValue>),
    /// A set.
    Set(Vec<ExportedValue>),
    /// A map, or a bag as a map from its elements to their multiplicities.
    Map(Vec<(ExportedValue, ExportedValue)>),
}

impl ExportedValue {
    pub(crate) fn of(value: &Value, naming: &Naming<'_>) -> Self {
        let list = |items: &[Value]| items.iter().map(|it| Self::of(it, naming)).collect();
        match value {
            Value::Undef => Self::Undef,
            Value::Bool(truth) => Self::Bool(*truth),
            Value::Int(number) => Self::Int(*number),
            Value::Text(text) => Self::Text(text.to_string()),
            Value::Char(sign) => Self::Text(sign.to_string()),
            Value::Real(_) | Value::Atom(_) | Value::Rule(_) | Value::Complex(_) => {
                Self::Text(value.show(naming).to_string())
            }
            Value::Tuple(items) => Self::Tuple(list(items)),
            Value::Seq(items) => Self::List(list(items)),
            Value::Set(items) => Self::Set(items.iter().map(|it| Self::of(it, naming)).collect()),
            Value::Bag(items) => {
                let count = |count: usize| Self::Int(i64::try_from(count).unwrap_or(i64::MAX));
                let pairs = items.iter();
                let pairs = pairs.map(|(item, times)| (Self::of(item, naming), count(*times)));
                Self::Map(pairs.collect())
            }
            Value::Map(pairs) => {
                let pairs = pairs.iter();
                let pairs = pairs.map(|(key, it)| (Self::of(key, naming), Self::of(it, naming)));
                Self::Map(pairs.collect())
            }
        }
    }
}
