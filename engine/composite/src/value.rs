//! Values of properties and arguments, after all substitutions.

use std::fmt;

use asmotion_coordinator::Constant;
use asmotion_datum::Datum;
use asmotion_diagnostics::FileId;
use serde::Serialize;
use serde::ser::{SerializeMap, Serializer};

use crate::tree::{self, Branch, Entry};

/// A value. Serialises as itself; a secret serialises and prints as `***`.
#[derive(Clone, PartialEq)]
pub enum SettingValue {
    /// A Boolean.
    Boolean(bool),
    /// A whole number.
    Integer(i64),
    /// A number with a fraction.
    Real(f64),
    /// A text.
    Text(String),
    /// A text that is never shown.
    Secret(String),
    /// A list.
    List(Vec<SettingValue>),
    /// Named values in the order they were written.
    Record(Vec<(String, SettingValue)>),
}

/// What is shown in place of a secret.
pub const REDACTED: &str = "***";

impl SettingValue {
    /// The value that a text of TOML writes, as in `[1.4, 4.7]`.
    pub fn from_toml(text: &str) -> Option<Self> {
        let (table, errors) = tree::parse(FileId::default(), &format!("value = {text}"));
        match (table.entries.as_slice(), errors.is_empty()) {
            ([entry], true) => Some(Self::of(&entry.node.value)),
            _ => None,
        }
    }

    pub(crate) fn of(branch: &Branch) -> Self {
        match branch {
            Branch::Text(text) | Branch::Date(text) => Self::Text(text.clone()),
            Branch::Integer(number) => Self::Integer(*number),
            Branch::Float(number) => Self::Real(*number),
            Branch::Boolean(truth) => Self::Boolean(*truth),
            Branch::List(items) => {
                Self::List(items.iter().map(|item| Self::of(&item.value)).collect())
            }
            Branch::Table(table) => {
                let fields = table.entries.iter();
                let field = |entry: &Entry| (entry.key.value.clone(), Self::of(&entry.node.value));
                Self::Record(fields.map(field).collect())
            }
        }
    }

    /// The value of data that travelled; `None` for what is absent.
    pub fn of_datum(datum: &Datum) -> Option<Self> {
        Some(match datum {
            Datum::Null => return None,
            Datum::Bool(truth) => Self::Boolean(*truth),
            Datum::Int(number) => Self::Integer(*number),
            Datum::Float(number) => Self::Real(*number),
            Datum::Text(text) => Self::Text(text.clone()),
            Datum::Bytes(_) | Datum::Numbers(_) | Datum::List(_) => {
                let elements = (0..datum.count()?).map(|at| Self::of_datum(&*datum.element(at)?));
                Self::List(elements.collect::<Option<_>>()?)
            }
            Datum::Record(entries) => {
                let fields = entries.iter();
                let field = |(name, value): &(asmotion_datum::FieldName, Datum)| {
                    Some((name.to_string(), Self::of_datum(value)?))
                };
                Self::Record(fields.filter_map(field).collect())
            }
        })
    }

    /// The number, also of a whole number.
    pub fn number(&self) -> Option<f64> {
        match self {
            Self::Integer(number) => Some(*number as f64),
            Self::Real(number) => Some(*number),
            Self::Boolean(_)
            | Self::Text(_)
            | Self::Secret(_)
            | Self::List(_)
            | Self::Record(_) => None,
        }
    }

    /// The same as data that travels; a secret is shown there.
    pub fn datum(&self) -> Datum {
        match self {
            Self::Boolean(truth) => Datum::Bool(*truth),
            Self::Integer(number) => Datum::Int(*number),
            Self::Real(number) => Datum::Float(*number),
            Self::Text(text) | Self::Secret(text) => Datum::Text(text.clone()),
            Self::List(items) => Datum::List(items.iter().map(Self::datum).collect()),
            Self::Record(fields) => Datum::record(
                fields
                    .iter()
                    .map(|(name, value)| (name.clone(), value.datum())),
            ),
        }
    }

    /// Whether a secret is in it.
    fn has_secret(&self) -> bool {
        match self {
            Self::Secret(_) => true,
            Self::List(items) => items.iter().any(Self::has_secret),
            Self::Record(fields) => fields.iter().any(|(_, value)| value.has_secret()),
            Self::Boolean(_) | Self::Integer(_) | Self::Real(_) | Self::Text(_) => false,
        }
    }

    /// What it is, for people.
    pub fn describe(&self) -> &'static str {
        match self {
            Self::Boolean(_) => "a Boolean",
            Self::Integer(_) => "an integer",
            Self::Real(_) => "a number",
            Self::Text(_) => "a string",
            Self::Secret(_) => "a secret",
            Self::List(_) => "a list",
            Self::Record(_) => "a table",
        }
    }
}

impl From<SettingValue> for Constant {
    fn from(value: SettingValue) -> Self {
        Self {
            secret: value.has_secret(),
            datum: value.datum(),
        }
    }
}

impl fmt::Display for SettingValue {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Boolean(truth) => truth.fmt(f),
            Self::Integer(number) => number.fmt(f),
            Self::Real(number) => write!(f, "{number:?}"),
            Self::Text(text) => write!(f, "{text:?}"),
            Self::Secret(_) => f.write_str(REDACTED),
            Self::List(items) => {
                f.write_str("[")?;
                for (index, item) in items.iter().enumerate() {
                    if index > 0 {
                        f.write_str(", ")?;
                    }
                    item.fmt(f)?;
                }
                f.write_str("]")
            }
            Self::Record(fields) => {
                f.write_str("{")?;
                for (index, (name, value)) in fields.iter().enumerate() {
                    let separator = if index > 0 { "," } else { "" };
                    write!(f, "{separator} {name} = {value}")?;
                }
                f.write_str(if fields.is_empty() { "}" } else { " }" })
            }
        }
    }
}

impl fmt::Debug for SettingValue {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        fmt::Display::fmt(self, f)
    }
}

impl Serialize for SettingValue {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match self {
            Self::Boolean(truth) => serializer.serialize_bool(*truth),
            Self::Integer(number) => serializer.serialize_i64(*number),
            Self::Real(number) => serializer.serialize_f64(*number),
            Self::Text(text) => serializer.serialize_str(text),
            Self::Secret(_) => serializer.serialize_str(REDACTED),
            Self::List(items) => serializer.collect_seq(items),
            Self::Record(fields) => {
                let mut map = serializer.serialize_map(Some(fields.len()))?;
                for (name, value) in fields {
                    map.serialize_entry(name, value)?;
                }
                map.end()
            }
        }
    }
}

/// Names and values, in the order they were declared or set.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PropertyValues(pub Vec<(String, SettingValue)>);

impl PropertyValues {
    /// The value of a property.
    pub fn get(&self, name: &str) -> Option<&SettingValue> {
        self.0
            .iter()
            .find(|(known, _)| known == name)
            .map(|(_, value)| value)
    }
}
