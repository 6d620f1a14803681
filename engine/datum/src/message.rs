//! Messages: Rust structs with a ROS name and a schema.

use std::any::Any;
use std::fmt::Debug;
use std::sync::Arc;

use serde::Serialize;
use serde::de::DeserializeOwned;

use crate::error::DatumError;
use crate::sample::Sample;
use crate::schema::{Schema, Shape};
use crate::value::Datum;

/// A message type, with a ROS name and a schema. Usually declared with the [`message!`](crate::message!) macro.
pub trait Message:
    Serialize + DeserializeOwned + Clone + Debug + PartialEq + Send + Sync + 'static
{
    /// The type's ROS name, for example `geometry_msgs/Twist`.
    const NAME: &'static str;

    /// The type's schema.
    fn schema() -> &'static Schema;

    /// Checks that the values can be meant: that they are finite where a quantity is, and of plausible size. Ports and services
    /// refuse messages that fail. The default accepts all values.
    ///
    /// # Errors
    /// [`DatumProblem::Implausible`](crate::DatumProblem::Implausible) with the path of the first such value.
    fn check(&self) -> Result<(), DatumError> {
        Ok(())
    }

    /// Converts the message to a datum. The macro [`message!`](crate::message!) compiles this conversion and the next one in
    /// the crate that declares the type, so that ports of the type in other crates do not compile them again.
    ///
    /// # Errors
    /// As [`Datum::of`].
    fn to_datum(&self) -> Result<Datum, DatumError> {
        Datum::of(self)
    }

    /// Converts a datum to a message.
    ///
    /// # Errors
    /// As [`Datum::to`].
    fn of_datum(datum: &Datum) -> Result<Self, DatumError> {
        datum.to()
    }

    /// The message that this one points to; `None` unless it is a pointer.
    fn pointee(&self) -> Option<Arc<dyn Sample>> {
        None
    }

    /// Makes a pointer to a message; `None` unless the type is a pointer to messages of this type.
    fn pointing_to(_: &Arc<dyn Sample>) -> Option<Self> {
        None
    }
}

impl<T: Message> Sample for T {
    fn type_name(&self) -> &'static str {
        T::NAME
    }

    fn to_datum(&self) -> Result<Datum, DatumError> {
        Message::to_datum(self)
    }

    fn to_shared(&self) -> Arc<dyn Sample> {
        Arc::new(self.clone())
    }

    fn pointee(&self) -> Option<Arc<dyn Sample>> {
        Message::pointee(self)
    }
}

impl dyn Sample {
    /// The message itself, if it has this type.
    pub fn downcast_ref<T: Message>(&self) -> Option<&T> {
        (self as &dyn Any).downcast_ref()
    }

    /// Converts the message to type `T`: without copying if it has that type, otherwise through its datum.
    ///
    /// # Errors
    /// The message has another type, and its datum does not fit `T`; the error names the place.
    pub fn read<T: Message>(self: Arc<Self>) -> Result<T, DatumError> {
        let sample = Sample::pointee(&*self).unwrap_or(self);
        if let Some(pointer) = T::pointing_to(&sample) {
            return Ok(pointer);
        }
        let any: Arc<dyn Any + Send + Sync> = sample.clone();
        match any.downcast::<T>() {
            Ok(same) => {
                drop(sample);
                Ok(Arc::unwrap_or_clone(same))
            }
            Err(_) => match sample.downcast_ref::<Datum>() {
                Some(datum) => T::of_datum(datum),
                None => T::of_datum(&Sample::to_datum(&*sample)?),
            },
        }
    }
}

/// Large messages are passed by pointer, so that many readers share one message.
impl<T: Message> Message for Arc<T> {
    const NAME: &'static str = T::NAME;

    fn schema() -> &'static Schema {
        T::schema()
    }

    fn check(&self) -> Result<(), DatumError> {
        T::check(self)
    }

    fn to_datum(&self) -> Result<Datum, DatumError> {
        T::to_datum(self)
    }

    fn of_datum(datum: &Datum) -> Result<Self, DatumError> {
        T::of_datum(datum).map(Self::new)
    }

    fn pointee(&self) -> Option<Arc<dyn Sample>> {
        Some(Arc::clone(self) as Arc<dyn Sample>)
    }

    fn pointing_to(sample: &Arc<dyn Sample>) -> Option<Self> {
        let any: Arc<dyn Any + Send + Sync> = Arc::clone(sample) as _;
        any.downcast().ok()
    }
}

/// A datum is a message whose type is known only at run time.
impl Message for Datum {
    const NAME: &'static str = "";

    fn schema() -> &'static Schema {
        static ANY: Schema = Schema {
            name: std::borrow::Cow::Borrowed(""),
            shape: Shape::Any,
        };
        &ANY
    }
}

/// Declares message types: the struct and its implementations of serde's traits, [`Default`] and [`Message`]. The
/// calling crate must know this one by the name `asmotion_datum`.
///
/// Fields have the order of the ROS definition, and doc comments with their units. The initial value of a field is
/// zero, or the value after `=`. In decoding, an omitted field gets its initial value, and an unknown field is an
/// error. Field types implement [`Described`](crate::Described): numbers, text, other messages, and lists, arrays and
/// options of them. `check = FUNCTION` after the ROS name adds a function to [`Message::check`], which otherwise checks the
/// messages in the fields.
///
/// ```
/// asmotion_datum::message! {
///     /// A rotation (geometry_msgs/Quaternion).
///     #[derive(Copy)]
///     pub struct Quaternion = "geometry_msgs/Quaternion" {
///         /// the vector part
///         pub x: f64,
///         pub y: f64,
///         pub z: f64,
///         /// the scalar part
///         pub w: f64 = 1.0,
///     }
/// }
/// assert_eq!(Quaternion::default().w, 1.0);
/// ```
#[macro_export]
macro_rules! message {
    ($(
        $(#[$meta:meta])*
        $vis:vis struct $name:ident = $ros:literal $(, check = $check:path)? {
            $($(#[doc = $doc:literal])* $field_vis:vis $field:ident: $type:ty $(= $initial:expr)?),* $(,)?
        }
    )+) => {
        $(
            $(#[$meta])*
            #[derive(Debug, Clone, PartialEq)]
            $vis struct $name {
                $(
                    $(#[doc = $doc])*
                    $field_vis $field: $type,
                )*
            }

            impl ::core::default::Default for $name {
                fn default() -> Self {
                    Self {
                        $($field: $crate::message!(@initial $type $(= $initial)?),)*
                    }
                }
            }

            impl $crate::Message for $name {
                const NAME: &'static str = $ros;

                fn schema() -> &'static $crate::Schema {
                    static SCHEMA: ::std::sync::OnceLock<$crate::Schema> = ::std::sync::OnceLock::new();
                    SCHEMA.get_or_init(|| {
                        $crate::Schema::record($ros, ::std::vec![$($crate::OutlineKey {
                            name: ::std::borrow::Cow::Borrowed(stringify!($field)),
                            doc: ::std::borrow::Cow::Borrowed(concat!($($doc),*).trim_ascii()),
                            schema: <$type as $crate::Described>::describe(),
                            initial: $crate::message!(@given $type $(= $initial)?),
                        }),*])
                    })
                }

                fn check(&self) -> ::core::result::Result<(), $crate::DatumError> {
                    $(
                        <$type as $crate::Described>::check_value(&self.$field)
                            .map_err(|error| error.within(stringify!($field)))?;
                    )*
                    $($check(self)?;)?
                    ::core::result::Result::Ok(())
                }

                fn to_datum(&self) -> ::core::result::Result<$crate::Datum, $crate::DatumError> {
                    $crate::Described::write(self)
                }

                fn of_datum(
                    datum: &$crate::Datum,
                ) -> ::core::result::Result<Self, $crate::DatumError> {
                    $crate::Described::read(datum)
                }
            }

            impl $crate::serde::Serialize for $name {
                fn serialize<S: $crate::serde::Serializer>(
                    &self,
                    serializer: S,
                ) -> ::core::result::Result<S::Ok, S::Error> {
                    $crate::field::serialize(self, serializer)
                }
            }

            impl<'de> $crate::serde::Deserialize<'de> for $name {
                fn deserialize<D: $crate::serde::Deserializer<'de>>(
                    deserializer: D,
                ) -> ::core::result::Result<Self, D::Error> {
                    $crate::field::deserialize(deserializer)
                }
            }

            impl $crate::Described for $name {
                fn describe() -> $crate::Schema {
                    <Self as $crate::Message>::schema().clone()
                }

                fn initial() -> Self {
                    <Self as ::core::default::Default>::default()
                }

                fn write(&self) -> ::core::result::Result<$crate::Datum, $crate::DatumError> {
                    ::core::result::Result::Ok($crate::Datum::Record(::std::vec![
                        $($crate::field::write(stringify!($field), &self.$field)?,)*
                    ]))
                }

                fn read(
                    datum: &$crate::Datum,
                ) -> ::core::result::Result<Self, $crate::DatumError> {
                    const FIELDS: &[&str] = &[$(stringify!($field)),*];
                    let mut message = <Self as ::core::default::Default>::default();
                    for (name, value) in $crate::field::entries(datum, stringify!($name), FIELDS)? {
                        match &**name {
                            $(stringify!($field) => message.$field = $crate::field::read(name, value)?,)*
                            _ => {}
                        }
                    }
                    ::core::result::Result::Ok(message)
                }

                fn check_value(&self) -> ::core::result::Result<(), $crate::DatumError> {
                    <Self as $crate::Message>::check(self)
                }
            }
        )+
    };
    (@given $type:ty = $initial:expr) => {{
        let initial: $type = $initial;
        $crate::field::datum(&initial)
    }};
    (@given $type:ty) => { $crate::Datum::Null };
    (@initial $type:ty = $initial:expr) => { $initial };
    (@initial $type:ty) => { <$type as $crate::Described>::initial() };
}
