//! Converts a [`Datum`] to any serde type, and any serde data to a datum.

use std::borrow::Cow;
use std::fmt;

use serde::Deserialize;
use serde::de::value::{BorrowedStrDeserializer, BytesDeserializer};
use serde::de::{
    self, DeserializeOwned, DeserializeSeed, Deserializer, EnumAccess, IntoDeserializer, MapAccess,
    SeqAccess, Unexpected, VariantAccess, Visitor,
};
use serde::forward_to_deserialize_any;

use crate::codec::special_float;
use crate::error::{DatumError, DatumProblem};
use crate::numbers::Numbers;
use crate::value::{Datum, FieldName};

impl Datum {
    /// Converts the datum to a type. An error names the place that does not fit.
    ///
    /// # Errors
    /// [`DatumProblem::Mismatch`](crate::DatumProblem::Mismatch) with the path of the first value that does not fit.
    pub fn to<T: DeserializeOwned>(&self) -> Result<T, DatumError> {
        T::deserialize(DatumDeserializer(self))
    }
}

/// Deserialises from one datum.
#[derive(Clone, Copy)]
struct DatumDeserializer<'de>(&'de Datum);

impl<'de> Deserializer<'de> for DatumDeserializer<'de> {
    type Error = DatumError;

    fn is_human_readable(&self) -> bool {
        false
    }

    fn deserialize_any<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, DatumError> {
        match self.0 {
            Datum::Null => visitor.visit_none(),
            Datum::Bool(value) => visitor.visit_bool(*value),
            Datum::Int(value) => visitor.visit_i64(*value),
            Datum::Float(value) => visitor.visit_f64(*value),
            Datum::Text(value) => visitor.visit_borrowed_str(value),
            Datum::Bytes(bytes) => visitor.visit_borrowed_bytes(bytes),
            Datum::Numbers(_) | Datum::List(_) => visitor.visit_seq(ListAccess {
                of: self.0,
                next: 0,
            }),
            Datum::Record(entries) => visitor.visit_map(RecordAccess {
                rest: entries.iter(),
                value: None,
            }),
        }
    }

    /// Accepts text for the floats that JSON cannot represent: `"NaN"`, `"Infinity"`, `"-Infinity"`.
    fn deserialize_f64<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, DatumError> {
        match self.0.as_text().and_then(special_float) {
            Some(value) => visitor.visit_f64(value),
            None => self.deserialize_any(visitor),
        }
    }

    fn deserialize_f32<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, DatumError> {
        self.deserialize_f64(visitor)
    }

    fn deserialize_option<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, DatumError> {
        if *self.0 == Datum::Null {
            return visitor.visit_none();
        }
        visitor.visit_some(self)
    }

    fn deserialize_unit<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, DatumError> {
        if let Datum::Null = self.0 {
            visitor.visit_unit()
        } else {
            Err(de::Error::invalid_type(
                Unexpected::Other(self.0.kind()),
                &visitor,
            ))
        }
    }

    /// Passes packed numbers in one block to a visitor that packs the same element type, and one by one to others.
    fn deserialize_newtype_struct<V: Visitor<'de>>(
        self,
        name: &'static str,
        visitor: V,
    ) -> Result<V::Value, DatumError> {
        let Datum::Numbers(numbers) = self.0 else {
            return visitor.visit_newtype_struct(self);
        };
        if name == WHOLE {
            return visitor.visit_map(PackedNumbersAccess(Some(numbers)));
        }
        if name == numbers.carrier() {
            let bytes = numbers.to_bytes();
            return visitor.visit_newtype_struct(BytesDeserializer::new(&bytes));
        }
        visitor.visit_newtype_struct(self)
    }

    fn deserialize_seq<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, DatumError> {
        if let Datum::Bytes(_) = self.0 {
            let next = 0;
            return visitor.visit_seq(ListAccess { of: self.0, next });
        }
        self.deserialize_any(visitor)
    }

    fn deserialize_tuple<V: Visitor<'de>>(
        self,
        _: usize,
        visitor: V,
    ) -> Result<V::Value, DatumError> {
        self.deserialize_seq(visitor)
    }

    fn deserialize_enum<V: Visitor<'de>>(
        self,
        _: &'static str,
        _: &'static [&'static str],
        visitor: V,
    ) -> Result<V::Value, DatumError> {
        if let Datum::Text(name) = self.0 {
            visitor.visit_enum(VariantDeserializer {
                name,
                content: None,
            })
        } else if let Datum::Record(entries) = self.0
            && let [(name, content)] = &**entries
        {
            visitor.visit_enum(VariantDeserializer {
                name,
                content: Some(content),
            })
        } else {
            Err(de::Error::invalid_type(
                Unexpected::Other(self.0.kind()),
                &"a variant's name, or a record of one variant",
            ))
        }
    }

    forward_to_deserialize_any! {
        bool i8 i16 i32 i64 i128 u8 u16 u32 u64 u128 char str string bytes byte_buf
        unit_struct tuple_struct map struct identifier ignored_any
    }
}

/// Iterates over the elements of a list, of packed numbers or of bytes.
struct ListAccess<'de> {
    of: &'de Datum,
    next: usize,
}

impl<'de> SeqAccess<'de> for ListAccess<'de> {
    type Error = DatumError;

    fn next_element_seed<T: DeserializeSeed<'de>>(
        &mut self,
        seed: T,
    ) -> Result<Option<T::Value>, DatumError> {
        let index = self.next;
        self.next += 1;
        match self.of.element(index) {
            None => Ok(None),
            Some(Cow::Borrowed(element)) => seed.deserialize(DatumDeserializer(element)).map(Some),
            Some(Cow::Owned(Datum::Int(value))) => {
                seed.deserialize(value.into_deserializer()).map(Some)
            }
            Some(Cow::Owned(Datum::Float(value))) => {
                seed.deserialize(value.into_deserializer()).map(Some)
            }
            Some(Cow::Owned(other)) => Err(DatumError::new(DatumProblem::Mismatch(format!(
                "found {} among packed numbers",
                other.kind()
            )))),
        }
        .map_err(|error: DatumError| error.within(index))
    }

    fn size_hint(&self) -> Option<usize> {
        self.of.count().map(|len| len.saturating_sub(self.next))
    }
}

/// Iterates over the entries of a record.
struct RecordAccess<'de> {
    rest: std::slice::Iter<'de, (FieldName, Datum)>,
    /// The entry whose key was read last, until its value is read.
    value: Option<&'de (FieldName, Datum)>,
}

impl<'de> MapAccess<'de> for RecordAccess<'de> {
    type Error = DatumError;

    fn next_key_seed<K: DeserializeSeed<'de>>(
        &mut self,
        seed: K,
    ) -> Result<Option<K::Value>, DatumError> {
        self.value = self.rest.next();
        let Some((name, _)) = self.value else {
            return Ok(None);
        };
        seed.deserialize(BorrowedStrDeserializer::new(name))
            .map(Some)
    }

    fn next_value_seed<V: DeserializeSeed<'de>>(
        &mut self,
        seed: V,
    ) -> Result<V::Value, DatumError> {
        let Some((name, value)) = self.value else {
            return Err(de::Error::custom("value requested before its key"));
        };
        seed.deserialize(DatumDeserializer(value))
            .map_err(|error| error.within(name))
    }

    fn size_hint(&self) -> Option<usize> {
        Some(self.rest.len())
    }
}

/// An enum value: a bare name, or a name with content.
struct VariantDeserializer<'de> {
    name: &'de str,
    content: Option<&'de Datum>,
}

impl<'de> EnumAccess<'de> for VariantDeserializer<'de> {
    type Error = DatumError;
    type Variant = Self;

    fn variant_seed<V: DeserializeSeed<'de>>(
        self,
        seed: V,
    ) -> Result<(V::Value, Self), DatumError> {
        let name = seed.deserialize(BorrowedStrDeserializer::<DatumError>::new(self.name))?;
        Ok((name, self))
    }
}

impl<'de> VariantDeserializer<'de> {
    fn content(&self) -> Result<DatumDeserializer<'de>, DatumError> {
        self.content.map(DatumDeserializer).ok_or_else(|| {
            DatumError::new(DatumProblem::Mismatch(format!(
                "variant `{}` needs content, found only its name",
                self.name
            )))
        })
    }
}

impl<'de> VariantAccess<'de> for VariantDeserializer<'de> {
    type Error = DatumError;

    fn unit_variant(self) -> Result<(), DatumError> {
        match self.content {
            None | Some(Datum::Null) => Ok(()),
            Some(other) => Err(de::Error::invalid_type(
                Unexpected::Other(other.kind()),
                &"a variant without content",
            )),
        }
    }

    fn newtype_variant_seed<T: DeserializeSeed<'de>>(
        self,
        seed: T,
    ) -> Result<T::Value, DatumError> {
        seed.deserialize(self.content()?)
            .map_err(|error| error.within(self.name))
    }

    fn tuple_variant<V: Visitor<'de>>(self, _: usize, visitor: V) -> Result<V::Value, DatumError> {
        self.content()?
            .deserialize_seq(visitor)
            .map_err(|error| error.within(self.name))
    }

    fn struct_variant<V: Visitor<'de>>(
        self,
        _: &'static [&'static str],
        visitor: V,
    ) -> Result<V::Value, DatumError> {
        self.content()?
            .deserialize_any(visitor)
            .map_err(|error| error.within(self.name))
    }
}

/// The newtype name with which `Datum` asks for the whole value, including packed numbers as such.
const WHOLE: &str = "datum::Datum";

/// Packed numbers on their way into a datum: one entry with the carrier's name and the bytes.
struct PackedNumbersAccess<'de>(Option<&'de Numbers>);

impl<'de> MapAccess<'de> for PackedNumbersAccess<'de> {
    type Error = DatumError;

    fn next_key_seed<K: DeserializeSeed<'de>>(
        &mut self,
        seed: K,
    ) -> Result<Option<K::Value>, DatumError> {
        let Some(numbers) = self.0 else {
            return Ok(None);
        };
        seed.deserialize(BorrowedStrDeserializer::new(numbers.carrier()))
            .map(Some)
    }

    fn next_value_seed<V: DeserializeSeed<'de>>(
        &mut self,
        seed: V,
    ) -> Result<V::Value, DatumError> {
        let bytes = self.0.take().map(Numbers::to_bytes).unwrap_or_default();
        seed.deserialize(BytesDeserializer::new(&bytes))
    }
}

/// Deserialises whatever kind of data the format contains.
impl<'de> Deserialize<'de> for Datum {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_newtype_struct(WHOLE, DatumVisitor)
    }
}

struct DatumVisitor;

impl<'de> Visitor<'de> for DatumVisitor {
    type Value = Datum;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("data")
    }

    fn visit_bool<E>(self, value: bool) -> Result<Datum, E> {
        Ok(Datum::Bool(value))
    }

    fn visit_i64<E>(self, value: i64) -> Result<Datum, E> {
        Ok(Datum::Int(value))
    }

    fn visit_u64<E: de::Error>(self, value: u64) -> Result<Datum, E> {
        i64::try_from(value)
            .map(Datum::Int)
            .map_err(|_| E::custom(DatumProblem::IntegerTooBig(value.to_string())))
    }

    fn visit_f64<E>(self, value: f64) -> Result<Datum, E> {
        Ok(Datum::Float(value))
    }

    fn visit_str<E>(self, value: &str) -> Result<Datum, E> {
        Ok(Datum::text(value))
    }

    fn visit_string<E>(self, value: String) -> Result<Datum, E> {
        Ok(Datum::Text(value))
    }

    fn visit_bytes<E>(self, value: &[u8]) -> Result<Datum, E> {
        Ok(Datum::Bytes(value.into()))
    }

    fn visit_none<E>(self) -> Result<Datum, E> {
        Ok(Datum::Null)
    }

    fn visit_unit<E>(self) -> Result<Datum, E> {
        Ok(Datum::Null)
    }

    fn visit_some<D: Deserializer<'de>>(self, deserializer: D) -> Result<Datum, D::Error> {
        Datum::deserialize(deserializer)
    }

    fn visit_newtype_struct<D: Deserializer<'de>>(
        self,
        deserializer: D,
    ) -> Result<Datum, D::Error> {
        deserializer.deserialize_any(self)
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut all: A) -> Result<Datum, A::Error> {
        let mut elements = Vec::with_capacity(all.size_hint().unwrap_or(0).min(4096));
        while let Some(element) = all.next_element()? {
            elements.push(element);
        }
        Ok(Datum::List(elements))
    }

    fn visit_map<A: MapAccess<'de>>(self, mut all: A) -> Result<Datum, A::Error> {
        let mut entries = Vec::with_capacity(all.size_hint().unwrap_or(0).min(4096));
        while let Some((name, value)) = all.next_entry::<String, Datum>()? {
            if let Datum::Bytes(bytes) = &value
                && let Some(numbers) = Numbers::from_carrier(&name, bytes)
            {
                return Ok(Datum::Numbers(numbers));
            }
            entries.push((Cow::Owned(name), value));
        }
        Ok(Datum::Record(entries))
    }
}
