//! Types that may be fields of messages, and their serialisation.

use std::fmt;
use std::marker::PhantomData;

use serde::de::{self, Deserialize, Deserializer, SeqAccess, Visitor};
use serde::ser::{Serialize, Serializer};

use crate::error::DatumError;
use crate::numbers::Packed;
use crate::schema::{Schema, Shape};
use crate::ser::RawBytes;
use crate::value::Datum;

/// A type that may be a field of a message. Provides its schema, its initial value and its serialisation.
///
/// The `_many` methods let number types pack a list into one byte string.
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

    /// Serialises a field.
    ///
    /// # Errors
    /// The error of the serializer, if the format cannot express the field.
    fn write<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error>;

    /// Deserialises a field.
    ///
    /// # Errors
    /// The error of the deserializer: its input is malformed, or does not fit the type.
    fn read<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error>;

    /// Serialises a list. The default writes element by element.
    ///
    /// # Errors
    /// The error of the serializer, if the format cannot express an element.
    fn write_many<S: Serializer>(many: &[Self], serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_seq(many.iter().map(SerializeDescribed))
    }

    /// Deserialises a list. The default reads element by element.
    ///
    /// # Errors
    /// The error of the deserializer: its input is not a list, or an element does not fit the type.
    fn read_many<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Vec<Self>, D::Error> {
        deserializer.deserialize_seq(ListVisitor(PhantomData))
    }
}

/// The functions through which [`message!`](crate::message!) serialises each field: `#[serde(with = "datum::field")]`.
pub mod field {
    use super::{Datum, Described, Deserializer, SerializeDescribed, Serializer};

    /// The initial value of a field as a datum; null if it cannot be represented.
    pub fn datum<T: Described>(value: &T) -> Datum {
        Datum::of(&SerializeDescribed(value)).unwrap_or_default()
    }

    /// Serialises a field.
    ///
    /// # Errors
    /// As [`Described::write`](super::Described::write).
    pub fn serialize<T: Described, S: Serializer>(
        value: &T,
        serializer: S,
    ) -> Result<S::Ok, S::Error> {
        value.write(serializer)
    }

    /// Deserialises a field.
    ///
    /// # Errors
    /// As [`Described::read`](super::Described::read).
    pub fn deserialize<'de, T: Described, D: Deserializer<'de>>(
        deserializer: D,
    ) -> Result<T, D::Error> {
        T::read(deserializer)
    }
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

            fn write<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
                self.serialize(serializer)
            }

            fn read<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
                Self::deserialize(deserializer)
            }
        })+
    };
}

scalar! {
    bool => Bool, false;
    u64 => U64, 0;
    String => Text, Self::new();
    Datum => Any, Self::Null;
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

            fn write<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
                self.serialize(serializer)
            }

            fn read<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
                Self::deserialize(deserializer)
            }

            fn write_many<S: Serializer>(many: &[Self], serializer: S) -> Result<S::Ok, S::Error> {
                if serializer.is_human_readable() {
                    return serializer.collect_seq(many);
                }
                serializer.serialize_newtype_struct(Self::NAME, &RawBytes(&Self::pack(many)))
            }

            fn read_many<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Vec<Self>, D::Error> {
                deserializer.deserialize_newtype_struct(Self::NAME, PackedVisitor(PhantomData))
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

    fn write<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_u8(*self)
    }

    fn read<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        Self::deserialize(deserializer)
    }

    fn write_many<S: Serializer>(many: &[Self], serializer: S) -> Result<S::Ok, S::Error> {
        if serializer.is_human_readable() {
            return serializer.collect_seq(many);
        }
        serializer.serialize_bytes(many)
    }

    fn read_many<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Vec<Self>, D::Error> {
        deserializer.deserialize_byte_buf(PackedVisitor(PhantomData))
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

    fn write<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        T::write_many(self, serializer)
    }

    fn read<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        T::read_many(deserializer)
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

    fn write<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        T::write_many(self, serializer)
    }

    fn read<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let all = T::read_many(deserializer)?;
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

    fn write<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match self {
            None => serializer.serialize_none(),
            Some(value) => serializer.serialize_some(&SerializeDescribed(value)),
        }
    }

    fn read<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        Option::<DeserializeDescribed<T>>::deserialize(deserializer)
            .map(|some| some.map(|reading| reading.0))
    }
}

/// Checks a list.
fn check_all<T: Described>(all: &[T]) -> Result<(), DatumError> {
    let mut elements = all.iter().enumerate();
    elements.try_for_each(|(index, one)| one.check_value().map_err(|error| error.within(index)))
}

/// Adapts a described value to serde's `Serialize`.
struct SerializeDescribed<'a, T>(&'a T);

impl<T: Described> Serialize for SerializeDescribed<'_, T> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        self.0.write(serializer)
    }
}

/// Adapts a described value to serde's `Deserialize`.
struct DeserializeDescribed<T>(T);

impl<'de, T: Described> Deserialize<'de> for DeserializeDescribed<T> {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        T::read(deserializer).map(Self)
    }
}

/// Limit on the number of elements for which memory is reserved because a peer announced them; beyond it, memory grows
/// with the elements received.
const TRUSTED_CAPACITY: usize = 4096;

fn read_all<'de, T: Described, A: SeqAccess<'de>>(mut from: A) -> Result<Vec<T>, A::Error> {
    let mut all = Vec::with_capacity(from.size_hint().unwrap_or(0).min(TRUSTED_CAPACITY));
    while let Some(DeserializeDescribed(element)) = from.next_element()? {
        all.push(element);
    }
    Ok(all)
}

/// Reads a list element by element.
struct ListVisitor<T>(PhantomData<T>);

impl<'de, T: Described> Visitor<'de> for ListVisitor<T> {
    type Value = Vec<T>;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "a list of {}", T::describe())
    }

    fn visit_seq<A: SeqAccess<'de>>(self, all: A) -> Result<Vec<T>, A::Error> {
        read_all(all)
    }
}

/// Reads a list of numbers, packed or one by one.
struct PackedVisitor<T>(PhantomData<T>);

impl<'de, T: Described + Packed> Visitor<'de> for PackedVisitor<T> {
    type Value = Vec<T>;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "a list of {}", T::describe())
    }

    fn visit_newtype_struct<D: Deserializer<'de>>(
        self,
        deserializer: D,
    ) -> Result<Vec<T>, D::Error> {
        deserializer.deserialize_any(self)
    }

    fn visit_bytes<E: de::Error>(self, bytes: &[u8]) -> Result<Vec<T>, E> {
        T::unpack(bytes).ok_or_else(|| {
            E::custom(format_args!(
                "{} bytes do not divide into {}",
                bytes.len(),
                T::describe()
            ))
        })
    }

    fn visit_seq<A: SeqAccess<'de>>(self, all: A) -> Result<Vec<T>, A::Error> {
        read_all(all)
    }
}
