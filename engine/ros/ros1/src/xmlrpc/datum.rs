//! Values of parameters as data, and back.

use std::borrow::Cow;

use asmotion_datum::Datum;

use super::value::XmlRpcValue;

/// A datum that the parameter server cannot hold.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("no parameter of ROS can be {0}")]
pub struct UnsupportedParameter(String);

impl XmlRpcValue {
    /// The value as a datum. A time becomes a text.
    pub fn to_datum(&self) -> Datum {
        match self {
            Self::Int(value) => Datum::Int(*value),
            Self::Bool(value) => Datum::Bool(*value),
            Self::Double(value) => Datum::Float(*value),
            Self::Text(text) | Self::Time(text) => Datum::text(text.clone()),
            Self::Bytes(bytes) => Datum::Bytes(bytes.as_slice().into()),
            Self::Array(elements) => Datum::List(elements.iter().map(Self::to_datum).collect()),
            Self::Struct(members) => {
                let entries = members.iter();
                let entries = entries.map(|(name, it)| (Cow::Owned(name.clone()), it.to_datum()));
                Datum::Record(entries.collect())
            }
        }
    }

    /// The datum as a value.
    ///
    /// # Errors
    /// An absent value, or an integer of more than 32 bits, which Python's XML-RPC refuses.
    pub fn of_datum(datum: &Datum) -> Result<Self, UnsupportedParameter> {
        Ok(match datum {
            Datum::Null => return Err(UnsupportedParameter("an absent value".to_owned())),
            Datum::Bool(value) => Self::Bool(*value),
            Datum::Int(value) => match i32::try_from(*value) {
                Ok(_) => Self::Int(*value),
                Err(_) => {
                    return Err(UnsupportedParameter(format!(
                        "{value}: integers have 32 bits"
                    )));
                }
            },
            Datum::Float(value) => Self::Double(*value),
            Datum::Text(text) => Self::text(text.clone()),
            Datum::Bytes(bytes) => Self::Bytes(bytes.to_vec()),
            Datum::Numbers(numbers) => {
                let elements = (0..numbers.len()).filter_map(|index| numbers.get(index));
                let elements = elements.map(|it| Self::of_datum(&it));
                Self::Array(elements.collect::<Result<_, _>>()?)
            }
            Datum::List(elements) => {
                let elements = elements.iter().map(Self::of_datum);
                Self::Array(elements.collect::<Result<_, _>>()?)
            }
            Datum::Record(entries) => {
                let members = entries.iter();
                let members = members.map(|(name, it)| Ok((name.to_string(), Self::of_datum(it)?)));
                Self::Struct(members.collect::<Result<_, _>>()?)
            }
        })
    }
}
