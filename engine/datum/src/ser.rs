//! Converts any serde value to a [`Datum`].

use std::borrow::Cow;

use serde::Serialize;
use serde::ser::{self, Serializer};

use crate::error::{DatumError, DatumProblem};
use crate::numbers::Numbers;
use crate::value::{Datum, FieldName};

impl Datum {
    /// Converts any serialisable value to a datum.
    ///
    /// # Errors
    /// An integer does not fit 64 bits with a sign, a map has keys that are not text, or `T::serialize` fails.
    pub fn of<T: Serialize + ?Sized>(value: &T) -> Result<Self, DatumError> {
        value.serialize(DatumSerializer)
    }
}

struct DatumSerializer;

type SerializeResult = Result<Datum, DatumError>;

fn integer<N: Copy + ToString>(value: N) -> SerializeResult
where
    i64: TryFrom<N>,
{
    i64::try_from(value)
        .map(Datum::Int)
        .map_err(|_| DatumError::new(DatumProblem::IntegerTooBig(value.to_string())))
}

/// A variant with content, represented as a record with one entry.
fn variant(name: &'static str, content: Datum) -> Datum {
    Datum::Record(vec![(Cow::Borrowed(name), content)])
}

impl Serializer for DatumSerializer {
    type Ok = Datum;
    type Error = DatumError;
    type SerializeSeq = ListSerializer;
    type SerializeTuple = ListSerializer;
    type SerializeTupleStruct = ListSerializer;
    type SerializeTupleVariant = ListSerializer;
    type SerializeMap = RecordSerializer;
    type SerializeStruct = RecordSerializer;
    type SerializeStructVariant = RecordSerializer;

    fn is_human_readable(&self) -> bool {
        false
    }

    fn serialize_bool(self, value: bool) -> SerializeResult {
        Ok(Datum::Bool(value))
    }

    fn serialize_i8(self, value: i8) -> SerializeResult {
        Ok(Datum::Int(value.into()))
    }

    fn serialize_i16(self, value: i16) -> SerializeResult {
        Ok(Datum::Int(value.into()))
    }

    fn serialize_i32(self, value: i32) -> SerializeResult {
        Ok(Datum::Int(value.into()))
    }

    fn serialize_i64(self, value: i64) -> SerializeResult {
        Ok(Datum::Int(value))
    }

    fn serialize_i128(self, value: i128) -> SerializeResult {
        integer(value)
    }

    fn serialize_u8(self, value: u8) -> SerializeResult {
        Ok(Datum::Int(value.into()))
    }

    fn serialize_u16(self, value: u16) -> SerializeResult {
        Ok(Datum::Int(value.into()))
    }

    fn serialize_u32(self, value: u32) -> SerializeResult {
        Ok(Datum::Int(value.into()))
    }

    fn serialize_u64(self, value: u64) -> SerializeResult {
        integer(value)
    }

    fn serialize_u128(self, value: u128) -> SerializeResult {
        integer(value)
    }

    fn serialize_f32(self, value: f32) -> SerializeResult {
        Ok(Datum::Float(value.into()))
    }

    fn serialize_f64(self, value: f64) -> SerializeResult {
        Ok(Datum::Float(value))
    }

    fn serialize_char(self, value: char) -> SerializeResult {
        Ok(Datum::Text(value.into()))
    }

    fn serialize_str(self, value: &str) -> SerializeResult {
        Ok(Datum::Text(value.to_owned()))
    }

    fn serialize_bytes(self, value: &[u8]) -> SerializeResult {
        Ok(Datum::Bytes(value.into()))
    }

    fn serialize_none(self) -> SerializeResult {
        Ok(Datum::Null)
    }

    fn serialize_some<T: Serialize + ?Sized>(self, value: &T) -> SerializeResult {
        value.serialize(self)
    }

    fn serialize_unit(self) -> SerializeResult {
        Ok(Datum::Null)
    }

    fn serialize_unit_struct(self, _name: &'static str) -> SerializeResult {
        Ok(Datum::Record(Vec::new()))
    }

    fn serialize_unit_variant(
        self,
        _: &'static str,
        _: u32,
        variant: &'static str,
    ) -> SerializeResult {
        Ok(Datum::text(variant))
    }

    fn serialize_newtype_struct<T: Serialize + ?Sized>(
        self,
        name: &'static str,
        value: &T,
    ) -> SerializeResult {
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
    ) -> SerializeResult {
        Ok(variant(name, value.serialize(self)?))
    }

    fn serialize_seq(self, len: Option<usize>) -> Result<ListSerializer, DatumError> {
        Ok(ListSerializer {
            variant: None,
            made: Vec::with_capacity(len.unwrap_or(0)),
        })
    }

    fn serialize_tuple(self, len: usize) -> Result<ListSerializer, DatumError> {
        self.serialize_seq(Some(len))
    }

    fn serialize_tuple_struct(
        self,
        _: &'static str,
        len: usize,
    ) -> Result<ListSerializer, DatumError> {
        self.serialize_seq(Some(len))
    }

    fn serialize_tuple_variant(
        self,
        _: &'static str,
        _: u32,
        variant: &'static str,
        len: usize,
    ) -> Result<ListSerializer, DatumError> {
        Ok(ListSerializer {
            variant: Some(variant),
            made: Vec::with_capacity(len),
        })
    }

    fn serialize_map(self, len: Option<usize>) -> Result<RecordSerializer, DatumError> {
        Ok(RecordSerializer {
            variant: None,
            key: Cow::Borrowed(""),
            made: Vec::with_capacity(len.unwrap_or(0)),
        })
    }

    fn serialize_struct(self, _: &'static str, len: usize) -> Result<RecordSerializer, DatumError> {
        self.serialize_map(Some(len))
    }

    fn serialize_struct_variant(
        self,
        _: &'static str,
        _: u32,
        variant: &'static str,
        len: usize,
    ) -> Result<RecordSerializer, DatumError> {
        Ok(RecordSerializer {
            variant: Some(variant),
            key: Cow::Borrowed(""),
            made: Vec::with_capacity(len),
        })
    }
}

/// Collects the elements of a list.
struct ListSerializer {
    /// The enum variant that the list is the content of, if any.
    variant: Option<&'static str>,
    made: Vec<Datum>,
}

impl ListSerializer {
    fn push<T: Serialize + ?Sized>(&mut self, value: &T) -> Result<(), DatumError> {
        let element = Datum::of(value).map_err(|error| error.within(self.made.len()))?;
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

/// Collects the entries of a record.
struct RecordSerializer {
    /// The enum variant that the record is the content of, if any.
    variant: Option<&'static str>,
    /// In a map, the key of the value to come.
    key: FieldName,
    made: Vec<(FieldName, Datum)>,
}

impl RecordSerializer {
    fn push<T: Serialize + ?Sized>(
        &mut self,
        name: FieldName,
        value: &T,
    ) -> Result<(), DatumError> {
        let entry = Datum::of(value).map_err(|error| error.within(&name))?;
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
        $(impl ser::$trait for ListSerializer {
            type Ok = Datum;
            type Error = DatumError;

            fn $method<T: Serialize + ?Sized>(&mut self, value: &T) -> Result<(), DatumError> {
                self.push(value)
            }

            fn end(self) -> SerializeResult {
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
        $(impl ser::$trait for RecordSerializer {
            type Ok = Datum;
            type Error = DatumError;

            fn serialize_field<T: Serialize + ?Sized>(
                &mut self,
                name: &'static str,
                value: &T,
            ) -> Result<(), DatumError> {
                self.push(Cow::Borrowed(name), value)
            }

            fn end(self) -> SerializeResult {
                Ok(self.finish())
            }
        })+
    };
}

entries! { SerializeStruct SerializeStructVariant }

impl ser::SerializeMap for RecordSerializer {
    type Ok = Datum;
    type Error = DatumError;

    fn serialize_key<T: Serialize + ?Sized>(&mut self, key: &T) -> Result<(), DatumError> {
        let Datum::Text(key) = Datum::of(key)? else {
            return Err(DatumError::new(DatumProblem::KeyNotText));
        };
        self.key = Cow::Owned(key);
        Ok(())
    }

    fn serialize_value<T: Serialize + ?Sized>(&mut self, value: &T) -> Result<(), DatumError> {
        let key = std::mem::replace(&mut self.key, Cow::Borrowed(""));
        self.push(key, value)
    }

    fn end(self) -> SerializeResult {
        Ok(self.finish())
    }
}

/// Serialises like the value that the datum represents.
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
                serializer.serialize_newtype_struct(numbers.carrier(), &RawBytes(&bytes))
            }
            Self::List(elements) => serializer.collect_seq(elements),
            Self::Record(entries) => {
                serializer.collect_map(entries.iter().map(|(name, value)| (name, value)))
            }
        }
    }
}

/// Serialises as a byte string, not as a list of numbers.
pub(crate) struct RawBytes<'a>(pub(crate) &'a [u8]);

impl Serialize for RawBytes<'_> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_bytes(self.0)
    }
}
