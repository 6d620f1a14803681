//! The datum: a value that includes its own structure.

use std::borrow::Cow;
use std::collections::BTreeSet;
use std::fmt;
use std::sync::Arc;

use crate::numbers::Numbers;

/// The name of a record's entry. Borrowed for names in the program text and [shared](crate::shared_name) ones, which avoids allocation.
pub type FieldName = Cow<'static, str>;

/// Data of any message type. An enum value without content is represented as [`Datum::Text`].
#[derive(Debug, Clone, PartialEq, Default)]
pub enum Datum {
    /// An absent optional value.
    #[default]
    Null,
    /// A Boolean.
    Bool(bool),
    /// An integer.
    Int(i64),
    /// A float, including NaN and infinities, which REP-117 needs.
    Float(f64),
    /// UTF-8 text.
    Text(String),
    /// Raw bytes, shared between clones.
    Bytes(Arc<[u8]>),
    /// Packed numbers, shared between clones.
    Numbers(Numbers),
    /// A list of elements.
    List(Vec<Datum>),
    /// Named entries in declaration order.
    Record(Vec<(FieldName, Datum)>),
}

impl Datum {
    /// A record with these entries.
    pub fn record<N: Into<FieldName>>(entries: impl IntoIterator<Item = (N, Datum)>) -> Self {
        Self::Record(
            entries
                .into_iter()
                .map(|(name, value)| (name.into(), value))
                .collect(),
        )
    }

    /// A text.
    pub fn text(text: impl Into<String>) -> Self {
        Self::Text(text.into())
    }

    /// The part at a path of names and indices, such as `pose.position.x` or `poses.0`. The empty path is the whole
    /// datum.
    ///
    /// An element of packed numbers or of bytes has to be created, hence the [`Cow`].
    pub fn get(&self, path: &str) -> Option<Cow<'_, Datum>> {
        let mut here = self;
        let mut segments = path.split('.').filter(|segment| !segment.is_empty());
        while let Some(segment) = segments.next() {
            here = match here {
                Self::Record(entries) => &entries.iter().find(|(name, _)| name == segment)?.1,
                Self::List(elements) => elements.get(segment.parse::<usize>().ok()?)?,
                Self::Numbers(_) | Self::Bytes(_) => {
                    let element = here.element(segment.parse().ok()?)?;
                    return segments.next().is_none().then_some(element);
                }
                Self::Null | Self::Bool(_) | Self::Int(_) | Self::Float(_) | Self::Text(_) => {
                    return None;
                }
            };
        }
        Some(Cow::Borrowed(here))
    }

    /// The element at an index of a list, of packed numbers or of bytes.
    pub fn element(&self, index: usize) -> Option<Cow<'_, Datum>> {
        match self {
            Self::List(elements) => elements.get(index).map(Cow::Borrowed),
            Self::Numbers(numbers) => numbers.get(index).map(Cow::Owned),
            Self::Bytes(bytes) => bytes
                .get(index)
                .map(|byte| Cow::Owned(Self::Int(i64::from(*byte)))),
            Self::Null
            | Self::Bool(_)
            | Self::Int(_)
            | Self::Float(_)
            | Self::Text(_)
            | Self::Record(_) => None,
        }
    }

    /// Number of elements or entries; `None` if the datum is not a list, bytes or a record.
    pub fn count(&self) -> Option<usize> {
        match self {
            Self::List(elements) => Some(elements.len()),
            Self::Numbers(numbers) => Some(numbers.len()),
            Self::Bytes(bytes) => Some(bytes.len()),
            Self::Record(entries) => Some(entries.len()),
            Self::Null | Self::Bool(_) | Self::Int(_) | Self::Float(_) | Self::Text(_) => None,
        }
    }

    /// Returns whether this is [`Datum::Null`].
    pub fn is_null(&self) -> bool {
        *self == Self::Null
    }

    /// The content of a [`Datum::Text`].
    pub fn as_text(&self) -> Option<&str> {
        if let Self::Text(text) = self {
            Some(text)
        } else {
            None
        }
    }

    /// The content of a [`Datum::Int`].
    pub fn as_int(&self) -> Option<i64> {
        if let Self::Int(value) = self {
            Some(*value)
        } else {
            None
        }
    }

    /// The content of a [`Datum::Float`] or, converted, of a [`Datum::Int`].
    pub fn as_float(&self) -> Option<f64> {
        if let Self::Float(value) = self {
            return Some(*value);
        }
        self.as_int().map(|value| value as f64)
    }

    /// The content of a [`Datum::Bool`].
    pub fn as_bool(&self) -> Option<bool> {
        if let Self::Bool(value) = self {
            Some(*value)
        } else {
            None
        }
    }

    /// The kind of data, as worded in error messages.
    pub fn kind(&self) -> &'static str {
        match self {
            Self::Null => "nothing",
            Self::Bool(_) => "a Boolean",
            Self::Int(_) => "an integer",
            Self::Float(_) => "a number",
            Self::Text(_) => "a string",
            Self::Bytes(_) => "bytes",
            Self::Numbers(_) => "packed numbers",
            Self::List(_) => "a list",
            Self::Record(_) => "a record",
        }
    }
}

/// Number of entries up to which each name is compared with all others.
const FEW: usize = 16;

/// Returns a name that occurs twice.
pub(crate) fn repeated(entries: &[(FieldName, Datum)]) -> Option<&str> {
    if entries.len() <= FEW {
        let mut named = entries.iter().enumerate();
        let repeated = named.find(|(index, (name, _))| {
            let mut before = entries.iter().take(*index);
            before.any(|(other, _)| other == name)
        });
        return repeated.map(|(_, (name, _))| &**name);
    }
    let mut known = BTreeSet::new();
    let mut names = entries.iter().map(|(name, _)| &**name);
    names.find(|name| !known.insert(*name))
}

impl From<bool> for Datum {
    fn from(value: bool) -> Self {
        Self::Bool(value)
    }
}

impl From<i64> for Datum {
    fn from(value: i64) -> Self {
        Self::Int(value)
    }
}

impl From<f64> for Datum {
    fn from(value: f64) -> Self {
        Self::Float(value)
    }
}

impl From<&str> for Datum {
    fn from(value: &str) -> Self {
        Self::Text(value.to_owned())
    }
}

impl From<String> for Datum {
    fn from(value: String) -> Self {
        Self::Text(value)
    }
}

/// Displays the datum on one line, with long lists abbreviated: `{x: 1.0, name: "a", ranges: 720 × f32}`.
impl fmt::Display for Datum {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Null => f.write_str("null"),
            Self::Bool(value) => write!(f, "{value}"),
            Self::Int(value) => write!(f, "{value}"),
            Self::Float(value) => write!(f, "{value:?}"),
            Self::Text(value) => write!(f, "{value:?}"),
            Self::Bytes(bytes) => write!(f, "{} bytes", bytes.len()),
            Self::Numbers(numbers) if numbers.len() > 8 => {
                write!(f, "{} × {}", numbers.len(), numbers.element())
            }
            Self::Numbers(numbers) => list(f, numbers.iter()),
            Self::List(elements) => list(f, elements.iter()),
            Self::Record(entries) => {
                f.write_str("{")?;
                for (index, (name, value)) in entries.iter().enumerate() {
                    let comma = if index == 0 { "" } else { ", " };
                    write!(f, "{comma}{name}: {value}")?;
                }
                f.write_str("}")
            }
        }
    }
}

fn list<D: fmt::Display>(
    f: &mut fmt::Formatter<'_>,
    elements: impl Iterator<Item = D>,
) -> fmt::Result {
    f.write_str("[")?;
    for (index, element) in elements.enumerate() {
        let comma = if index == 0 { "" } else { ", " };
        write!(f, "{comma}{element}")?;
    }
    f.write_str("]")
}
