//! Any serde value into a [`Datum`].

use std::borrow::Cow;

use serde::Serialize;
use serde::ser::{self, Serializer};

use crate::numbers::Numbers;
use crate::{Datum, DatumError, Name, Problem};

/// Builds the datum that describes a value.
pub(crate) fn datum_of<T: Serialize + ?Sized>(value: &T) -> Result<Datum, DatumError> {
    value.serialize(ToDatum)
}

struct ToDatum;

type Made = Result<Datum, DatumError>;

fn integer<N: Copy + ToString>(value: N) -> Made
where
    i64: TryFrom<N>,
{
    i64::try_from(value)
        .map(Datum::Int)
        .map_err(|_| DatumError::new(Problem::IntegerTooBig(value.to_string())))
}

/// How serde carries a variant with content: a record of one entry.
fn variant(name: &'static str, content: Datum) -> Datum {
    Datum::Record(vec![(Cow::Borrowed(name), content)])
}

impl Serializer for ToDatum {
    type Ok = Datum;
    type Error = DatumError;
    type SerializeSeq = Elements;
    type SerializeTuple = Elements;
    type SerializeTupleStruct = Elements;
    type SerializeTupleVariant = Elements;
    type SerializeMap = Entries;
    type SerializeStruct = Entries;
    type SerializeStructVariant = Entries;

    fn is_human_readable(&self) -> bool {
        false
    }

    fn serialize_bool(self, value: bool) -> Made {
        Ok(Datum::Bool(value))
    }

    fn serialize_i8(self, value: i8) -> Made {
        Ok(Datum::Int(value.into()))
    }

    fn serialize_i16(self, value: i16) -> Made {
        Ok(Datum::Int(value.into()))
    }

    fn serialize_i32(self, value: i32) -> Made {
        Ok(Datum::Int(value.into()))
    }

    fn serialize_i64(self, value: i64) -> Made {
        Ok(Datum::Int(value))
    }

    fn serialize_i128(self, value: i128) -> Made {
        integer(value)
    }

    fn serialize_u8(self, value: u8) -> Made {
        Ok(Datum::Int(value.into()))
    }

    fn serialize_u16(self, value: u16) -> Made {
        Ok(Datum::Int(value.into()))
    }

    fn serialize_u32(self, value: u32) -> Made {
        Ok(Datum::Int(value.into()))
    }

    fn serialize_u64(self, value: u64) -> Made {
        integer(value)
    }

    fn serialize_u128(self, value: u128) -> Made {
        integer(value)
    }

    fn serialize_f32(self, value: f32) -> Made {
        Ok(Datum::Float(value.into()))
    }

    fn serialize_f64(self, value: f64) -> Made {
        Ok(Datum::Float(value))
    }

    fn serialize_char(self, value: char) -> Made {
        Ok(Datum::Text(value.into()))
    }

    fn serialize_str(self, value: &str) -> Made {
        Ok(Datum::Text(value.to_owned()))
    }

    fn serialize_bytes(self, value: &[u8]) -> Made {
        Ok(Datum::Bytes(value.into()))
    }

    fn serialize_none(self) -> Made {
        Ok(Datum::Null)
    }

    fn serialize_some<T: Serialize + ?Sized>(self, value: &T) -> Made {
        value.serialize(self)
    }

    fn serialize_unit(self) -> Made {
        Ok(Datum::Null)
    }

    fn serialize_unit_struct(self, _name: &'static str) -> Made {
        Ok(Datum::Record(Vec::new()))
    }

    fn serialize_unit_variant(self, _: &'static str, _: u32, variant: &'static str) -> Made {
        Ok(Datum::text(variant))
    }

    fn serialize_newtype_struct<T: Serialize + ?Sized>(
        self,
        name: &'static str,
        value: &T,
    ) -> Made {
        let content = value.serialize(self)?;
        if let Datum::Bytes(bytes) = &content
            && let Some(numbers) = Numbers::from_carrier(name, bytes)
        {
            return Ok(Datum::Numbers(numbers));
        }
        Ok(content)
    }

    fn serialize_newtype_variant<T: Serialize + ?Sized>(
        self,
        _: &'static str,
        _: u32,
        name: &'static str,
        value: &T,
    ) -> Made {
        Ok(variant(name, value.serialize(self)?))
    }

    fn serialize_seq(self, len: Option<usize>) -> Result<Elements, DatumError> {
        Ok(Elements {
            variant: None,
            made: Vec::with_capacity(len.unwrap_or(0)),
        })
    }

    fn serialize_tuple(self, len: usize) -> Result<Elements, DatumError> {
        self.serialize_seq(Some(len))
    }

    fn serialize_tuple_struct(self, _: &'static str, len: usize) -> Result<Elements, DatumError> {
        self.serialize_seq(Some(len))
    }

    fn serialize_tuple_variant(
        self,
        _: &'static str,
        _: u32,
        variant: &'static str,
        len: usize,
    ) -> Result<Elements, DatumError> {
        Ok(Elements {
            variant: Some(variant),
            made: Vec::with_capacity(len),
        })
    }

    fn serialize_map(self, len: Option<usize>) -> Result<Entries, DatumError> {
        Ok(Entries {
            variant: None,
            key: Cow::Borrowed(""),
            made: Vec::with_capacity(len.unwrap_or(0)),
        })
    }

    fn serialize_struct(self, _: &'static str, len: usize) -> Result<Entries, DatumError> {
        self.serialize_map(Some(len))
    }

    fn serialize_struct_variant(
        self,
        _: &'static str,
        _: u32,
        variant: &'static str,
        len: usize,
    ) -> Result<Entries, DatumError> {
        Ok(Entries {
            variant: Some(variant),
            key: Cow::Borrowed(""),
            made: Vec::with_capacity(len),
        })
    }
}

/// A list in the making.
struct Elements {
    /// The enum variant whose content this is.
    variant: Option<&'static str>,
    made: Vec<Datum>,
}

impl Elements {
    fn push<T: Serialize + ?Sized>(&mut self, value: &T) -> Result<(), DatumError> {
        let element = datum_of(value).map_err(|error| error.within(self.made.len()))?;
        self.made.push(element);
        Ok(())
    }

    fn finish(self) -> Datum {
        let list = Datum::List(self.made);
        match self.variant {
            Some(name) => variant(name, list),
            None => list,
        }
    }
}

/// A record in the making.
struct Entries {
    /// The enum variant whose content this is.
    variant: Option<&'static str>,
    /// The key whose value comes next, of a map.
    key: Name,
    made: Vec<(Name, Datum)>,
}

impl Entries {
    fn push<T: Serialize + ?Sized>(&mut self, name: Name, value: &T) -> Result<(), DatumError> {
        let entry = datum_of(value).map_err(|error| error.within(&name))?;
        self.made.push((name, entry));
        Ok(())
    }

    fn finish(self) -> Datum {
        let record = Datum::Record(self.made);
        match self.variant {
            Some(name) => variant(name, record),
            None => record,
        }
    }
}

macro_rules! elements {
    ($($trait:ident $method:ident)+) => {
        $(impl ser::$trait for Elements {
            type Ok = Datum;
            type Error = DatumError;

            fn $method<T: Serialize + ?Sized>(&mut self, value: &T) -> Result<(), DatumError> {
                self.push(value)
            }

            fn end(self) -> Made {
                Ok(self.finish())
            }
        })+
    };
}

elements! {
    SerializeSeq serialize_element
    SerializeTuple serialize_element
    SerializeTupleStruct serialize_field
    SerializeTupleVariant serialize_field
}

macro_rules! entries {
    ($($trait:ident)+) => {
        $(impl ser::$trait for Entries {
            type Ok = Datum;
            type Error = DatumError;

            fn serialize_field<T: Serialize + ?Sized>(
                &mut self,
                name: &'static str,
                value: &T,
            ) -> Result<(), DatumError> {
                self.push(Cow::Borrowed(name), value)
            }

            fn end(self) -> Made {
                Ok(self.finish())
            }
        })+
    };
}

entries! { SerializeStruct SerializeStructVariant }

impl ser::SerializeMap for Entries {
    type Ok = Datum;
    type Error = DatumError;

    fn serialize_key<T: Serialize + ?Sized>(&mut self, key: &T) -> Result<(), DatumError> {
        let Datum::Text(key) = datum_of(key)? else {
            return Err(DatumError::new(Problem::KeyNotText));
        };
        self.key = Cow::Owned(key);
        Ok(())
    }

    fn serialize_value<T: Serialize + ?Sized>(&mut self, value: &T) -> Result<(), DatumError> {
        let key = std::mem::replace(&mut self.key, Cow::Borrowed(""));
        self.push(key, value)
    }

    fn end(self) -> Made {
        Ok(self.finish())
    }
}

/// A datum is serialisable like the value it describes.
impl Serialize for Datum {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match self {
            Self::Null => serializer.serialize_none(),
            Self::Bool(value) => serializer.serialize_bool(*value),
            Self::Int(value) => serializer.serialize_i64(*value),
            Self::Float(value) => serializer.serialize_f64(*value),
            Self::Text(value) => serializer.serialize_str(value),
            Self::Bytes(bytes) if serializer.is_human_readable() => {
                serializer.collect_seq(bytes.iter())
            }
            Self::Bytes(bytes) => serializer.serialize_bytes(bytes),
            Self::Numbers(numbers) if serializer.is_human_readable() => {
                serializer.collect_seq(numbers.iter())
            }
            Self::Numbers(numbers) => {
                let bytes = numbers.to_bytes();
                serializer.serialize_newtype_struct(numbers.carrier(), &Raw(&bytes))
            }
            Self::List(elements) => serializer.collect_seq(elements),
            Self::Record(entries) => {
                serializer.collect_map(entries.iter().map(|(name, value)| (name, value)))
            }
        }
    }
}

/// Bytes that serialise as bytes, not as a list of numbers.
pub(crate) struct Raw<'a>(pub(crate) &'a [u8]);

impl Serialize for Raw<'_> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_bytes(self.0)
    }
}
