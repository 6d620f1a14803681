//! Values of properties and arguments after substitution.

use std::fmt;

use asmotion_coordinator::Constant;
use asmotion_datum::Datum;
use asmotion_diagnostics::FileId;
use serde::Serialize;
use serde::ser::{SerializeMap, Serializer};

use crate::tree::{self, Branch, Entry};

/// A value. Secrets are serialised and displayed as `***`.
#[derive(Clone, PartialEq)]
pub enum SettingValue {
    /// Boolean.
    Boolean(bool),
    /// Integer.
    Integer(i64),
    /// Floating-point number.
    Real(f64),
    /// String.
    Text(String),
    /// String that is never displayed.
    Secret(String),
    /// List of values.
    List(Vec<SettingValue>),
    /// Named values in file order.
    Record(Vec<(String, SettingValue)>),
}

/// Replacement for displayed secrets.
pub const REDACTED: &str = "***";

impl SettingValue {
    /// Parses a TOML value such as `[1.4, 4.7]`; `None` if it is malformed.
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

    /// Converts from a datum; `None` for null.
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

    /// Returns the value as a floating-point number if it is numeric.
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

    /// Converts to a datum, including secrets in plain text.
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

    /// Returns whether the value contains a secret.
    fn has_secret(&self) -> bool {
        match self {
            Self::Secret(_) => true,
            Self::List(items) => items.iter().any(Self::has_secret),
            Self::Record(fields) => fields.iter().any(|(_, value)| value.has_secret()),
            Self::Boolean(_) | Self::Integer(_) | Self::Real(_) | Self::Text(_) => false,
        }
    }

    /// Returns the type for use in messages.
    pub fn describe(&self) -> &'static str {
        match self {
            Self::Boolean(_) => "a Boolean",
            Self::Integer(_) => "an integer",
            Self::Real(_) => "a floating-point number",
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

/// Names and values in declaration or file order.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PropertyValues(pub Vec<(String, SettingValue)>);

impl PropertyValues {
    /// Returns the value of a property.
    pub fn get(&self, name: &str) -> Option<&SettingValue> {
        self.0
            .iter()
            .find(|(known, _)| known == name)
            .map(|(_, value)| value)
    }
}
