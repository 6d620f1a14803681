//! Types that may be fields of messages, and their conversion to and from data.

use serde::de::{self, DeserializeOwned, Unexpected};

use crate::error::DatumError;
use crate::numbers::Numbers;
use crate::schema::{Schema, Shape};
use crate::value::Datum;

/// A type that may be a field of a message. Provides its schema, its initial value and its conversion to and from data.
///
/// The conversion is not generic, so a type's conversion is compiled once, in the crate that declares the type. The
/// `_many` methods let number types pack a list into one block.
pub trait Described: Sized {
    /// The schema of the type.
    fn describe() -> Schema;

    /// The value of the field in a new message: zero, empty or false.
    fn initial() -> Self;

    /// Checks that the value can be meant; see [`Message::check`](crate::Message::check). Numbers alone are always accepted.
    ///
    /// # Errors
    /// The problem, with its path in the value.
    fn check_value(&self) -> Result<(), DatumError> {
        Ok(())
    }

    /// Converts a field to a datum.
    ///
    /// # Errors
    /// The field cannot be represented: an integer beyond 64 bits with a sign.
    fn write(&self) -> Result<Datum, DatumError>;

    /// Converts a datum to a field.
    ///
    /// # Errors
    /// The datum does not fit the type; the error names the place.
    fn read(datum: &Datum) -> Result<Self, DatumError>;

    /// Converts a list to a datum. The default converts element by element.
    ///
    /// # Errors
    /// An element cannot be represented.
    fn write_many(many: &[Self]) -> Result<Datum, DatumError> {
        let elements = many.iter().enumerate().map(|(index, element)| {
            let datum = element.write();
            datum.map_err(|error| error.within(index))
        });
        elements.collect::<Result<_, _>>().map(Datum::List)
    }

    /// Converts a datum to a list. The default converts element by element.
    ///
    /// # Errors
    /// The datum is not a list, or an element does not fit the type.
    fn read_many(datum: &Datum) -> Result<Vec<Self>, DatumError> {
        read_each(datum)
    }
}

/// The functions through which [`message!`](crate::message!) converts fields, and with which a struct of serde packs a field:
/// `#[serde(with = "asmotion_datum::field")]`.
pub mod field {
    use serde::{Deserialize, Deserializer, Serialize, Serializer, de, ser};

    use super::{Datum, DatumError, Described, unexpected};
    use crate::value::FieldName;

    /// Serialises a field as the datum that it converts to.
    ///
    /// # Errors
    /// As [`Described::write`], or the format cannot express the datum.
    pub fn serialize<T: Described, S: Serializer>(
        value: &T,
        serializer: S,
    ) -> Result<S::Ok, S::Error> {
        let datum = value.write().map_err(ser::Error::custom)?;
        datum.serialize(serializer)
    }

    /// Deserialises a datum and converts it to a field.
    ///
    /// # Errors
    /// The input is malformed, or as [`Described::read`].
    pub fn deserialize<'de, T: Described, D: Deserializer<'de>>(
        deserializer: D,
    ) -> Result<T, D::Error> {
        let datum = Datum::deserialize(deserializer)?;
        T::read(&datum).map_err(de::Error::custom)
    }

    /// The initial value of a field as a datum; null if it cannot be represented.
    pub fn datum<T: Described>(value: &T) -> Datum {
        value.write().unwrap_or_default()
    }

    /// Converts a named field to an entry of a record.
    ///
    /// # Errors
    /// As [`Described::write`], with the name in the path.
    pub fn write<T: Described>(
        name: &'static str,
        value: &T,
    ) -> Result<(FieldName, Datum), DatumError> {
        let datum = value.write().map_err(|error| error.within(name))?;
        Ok((FieldName::Borrowed(name), datum))
    }

    /// Converts an entry of a record to a field.
    ///
    /// # Errors
    /// As [`Described::read`], with the name in the path.
    pub fn read<T: Described>(name: &str, datum: &Datum) -> Result<T, DatumError> {
        T::read(datum).map_err(|error| error.within(name))
    }

    /// The entries of a record, each of which names another field.
    ///
    /// # Errors
    /// The datum is not a record, or an entry is unknown or repeated.
    pub fn entries<'a>(
        datum: &'a Datum,
        record: &str,
        fields: &'static [&'static str],
    ) -> Result<&'a [(FieldName, Datum)], DatumError> {
        let Datum::Record(entries) = datum else {
            let expected = format!("struct {record}");
            return Err(de::Error::invalid_type(unexpected(datum), &&*expected));
        };
        // ends at the latest after one entry more than there are fields
        for (index, (name, _)) in entries.iter().enumerate() {
            let Some(field) = fields.iter().find(|field| **field == name) else {
                return Err(de::Error::unknown_field(name, fields));
            };
            if entries.iter().take(index).any(|(before, _)| before == name) {
                return Err(de::Error::duplicate_field(field));
            }
        }
        Ok(entries)
    }
}

/// Describes a datum in errors of serde.
fn unexpected(datum: &Datum) -> Unexpected<'_> {
    match datum {
        Datum::Null => Unexpected::Option,
        Datum::Bool(value) => Unexpected::Bool(*value),
        Datum::Int(value) => Unexpected::Signed(*value),
        Datum::Float(value) => Unexpected::Float(*value),
        Datum::Text(value) => Unexpected::Str(value),
        Datum::Bytes(bytes) => Unexpected::Bytes(bytes),
        Datum::Numbers(_) | Datum::List(_) => Unexpected::Seq,
        Datum::Record(_) => Unexpected::Map,
    }
}

/// Converts a list, packed numbers or bytes element by element.
fn read_each<T: Described>(datum: &Datum) -> Result<Vec<T>, DatumError> {
    let element = |index, datum: &Datum| T::read(datum).map_err(|error| error.within(index));
    match datum {
        Datum::List(elements) => {
            let elements = elements.iter().enumerate();
            elements.map(|(index, it)| element(index, it)).collect()
        }
        Datum::Numbers(numbers) => {
            let numbers = numbers.iter().enumerate();
            numbers.map(|(index, it)| element(index, &it)).collect()
        }
        Datum::Bytes(bytes) => {
            let bytes = bytes.iter().enumerate();
            bytes
                .map(|(index, byte)| element(index, &Datum::Int(i64::from(*byte))))
                .collect()
        }
        Datum::Null
        | Datum::Bool(_)
        | Datum::Int(_)
        | Datum::Float(_)
        | Datum::Text(_)
        | Datum::Record(_) => {
            let expected = format!("a list of {}", T::describe());
            Err(de::Error::invalid_type(unexpected(datum), &&*expected))
        }
    }
}

/// Converts a datum to a type of the standard library.
fn read_plain<T: DeserializeOwned>(datum: &Datum) -> Result<T, DatumError> {
    datum.to()
}

macro_rules! scalar {
    ($($type:ty => $shape:ident, $initial:expr;)+) => {
        $(impl Described for $type {
            fn describe() -> Schema {
                Schema::plain(Shape::$shape)
            }

            fn initial() -> Self {
                $initial
            }

            fn write(&self) -> Result<Datum, DatumError> {
                Datum::of(self)
            }

            fn read(datum: &Datum) -> Result<Self, DatumError> {
                read_plain(datum)
            }
        })+
    };
}

scalar! {
    bool => Bool, false;
    u64 => U64, 0;
    String => Text, Self::new();
}

/// Data of any type.
impl Described for Datum {
    fn describe() -> Schema {
        Schema::plain(Shape::Any)
    }

    fn initial() -> Self {
        Self::Null
    }

    fn write(&self) -> Result<Datum, DatumError> {
        Ok(self.clone())
    }

    fn read(datum: &Datum) -> Result<Self, DatumError> {
        Ok(datum.clone())
    }
}

macro_rules! packed {
    ($($type:ty => $shape:ident, $initial:expr;)+) => {
        $(impl Described for $type {
            fn describe() -> Schema {
                Schema::plain(Shape::$shape)
            }

            fn initial() -> Self {
                $initial
            }

            fn write(&self) -> Result<Datum, DatumError> {
                Datum::of(self)
            }

            fn read(datum: &Datum) -> Result<Self, DatumError> {
                read_plain(datum)
            }

            fn write_many(many: &[Self]) -> Result<Datum, DatumError> {
                Ok(Datum::Numbers(Numbers::$shape(many.into())))
            }

            fn read_many(datum: &Datum) -> Result<Vec<Self>, DatumError> {
                match datum {
                    Datum::Numbers(Numbers::$shape(numbers)) => Ok(numbers.to_vec()),
                    // a byte string is a list of unsigned bytes, whatever the elements of the field
                    Datum::Bytes(_)
                    | Datum::Numbers(_)
                    | Datum::List(_)
                    | Datum::Null
                    | Datum::Bool(_)
                    | Datum::Int(_)
                    | Datum::Float(_)
                    | Datum::Text(_)
                    | Datum::Record(_) => read_each(datum),
                }
            }
        })+
    };
}

packed! {
    i8 => I8, 0;
    i16 => I16, 0;
    u16 => U16, 0;
    i32 => I32, 0;
    u32 => U32, 0;
    i64 => I64, 0;
    f32 => F32, 0.0;
    f64 => F64, 0.0;
}

/// A single byte; a list of them is a byte string.
impl Described for u8 {
    fn describe() -> Schema {
        Schema::plain(Shape::U8)
    }

    fn initial() -> Self {
        0
    }

    fn write(&self) -> Result<Datum, DatumError> {
        Datum::of(self)
    }

    fn read(datum: &Datum) -> Result<Self, DatumError> {
        read_plain(datum)
    }

    fn write_many(many: &[Self]) -> Result<Datum, DatumError> {
        Ok(Datum::Bytes(many.into()))
    }
}

impl<T: Described> Described for Vec<T> {
    fn describe() -> Schema {
        Schema::many(T::describe(), None)
    }

    fn initial() -> Self {
        Self::new()
    }

    fn check_value(&self) -> Result<(), DatumError> {
        check_all(self)
    }

    fn write(&self) -> Result<Datum, DatumError> {
        T::write_many(self)
    }

    fn read(datum: &Datum) -> Result<Self, DatumError> {
        T::read_many(datum)
    }
}

impl<T: Described, const N: usize> Described for [T; N] {
    fn describe() -> Schema {
        Schema::many(T::describe(), Some(N))
    }

    fn initial() -> Self {
        std::array::from_fn(|_| T::initial())
    }

    fn check_value(&self) -> Result<(), DatumError> {
        check_all(self)
    }

    fn write(&self) -> Result<Datum, DatumError> {
        T::write_many(self)
    }

    fn read(datum: &Datum) -> Result<Self, DatumError> {
        let all = T::read_many(datum)?;
        all.try_into().map_err(|all: Vec<T>| {
            de::Error::custom(format_args!("expected {N} elements, found {}", all.len()))
        })
    }
}

impl<T: Described> Described for Option<T> {
    fn describe() -> Schema {
        Schema::plain(Shape::Option(Box::new(T::describe())))
    }

    fn initial() -> Self {
        None
    }

    fn check_value(&self) -> Result<(), DatumError> {
        self.as_ref().map_or(Ok(()), T::check_value)
    }

    fn write(&self) -> Result<Datum, DatumError> {
        self.as_ref().map_or(Ok(Datum::Null), T::write)
    }

    fn read(datum: &Datum) -> Result<Self, DatumError> {
        if datum.is_null() {
            return Ok(None);
        }
        T::read(datum).map(Some)
    }
}

/// Checks a list.
fn check_all<T: Described>(all: &[T]) -> Result<(), DatumError> {
    let mut elements = all.iter().enumerate();
    elements.try_for_each(|(index, one)| one.check_value().map_err(|error| error.within(index)))
}
