//! Packed lists of numbers, such as an occupancy grid, a laser scan or a covariance.
//!
//! All elements are in one allocation, which clones share, and in one byte string on the wire (typed arrays, RFC 8746).
//! Encoded element by element, the same data costs 4 to 75 times more.

use std::sync::Arc;

use crate::schema::Shape;
use crate::value::Datum;

macro_rules! numbers {
    ($($(#[$meta:meta])* $variant:ident($element:ty) = $name:literal, tag $tag:literal, $wrap:ident($via:ty);)+) => {
        /// A packed list of numbers of one type.
        #[derive(Debug, Clone, PartialEq)]
        pub enum Numbers {
            $($(#[$meta])* $variant(Arc<[$element]>),)+
        }

        impl Numbers {
            /// Number of elements.
            pub fn len(&self) -> usize {
                match self { $(Self::$variant(all) => all.len(),)+ }
            }

            /// The number at an index.
            pub fn get(&self, index: usize) -> Option<Datum> {
                match self {
                    $(Self::$variant(all) => all.get(index).map(|one| Datum::$wrap(<$via>::from(*one))),)+
                }
            }

            /// The elements as little-endian bytes.
            pub fn to_bytes(&self) -> Vec<u8> {
                match self {
                    $(Self::$variant(all) => <$element as Packed>::pack(all),)+
                }
            }

            /// Appends the elements as little-endian bytes.
            pub(crate) fn append_to(&self, bytes: &mut Vec<u8>) {
                match self {
                    $(Self::$variant(all) => <$element as Packed>::append(all, bytes),)+
                }
            }

            /// The RFC 8746 tag of a little-endian typed array of this element type.
            pub fn tag(&self) -> u64 {
                match self { $(Self::$variant(_) => $tag,)+ }
            }

            /// Reads the content of an RFC 8746 typed array. Returns `None` for any other tag, or if the length is not
            /// a multiple of the element size.
            pub fn from_tagged(tag: u64, bytes: &[u8]) -> Option<Self> {
                match tag {
                    $($tag => <$element as Packed>::unpack(bytes).map(Self::$variant),)+
                    _ => None,
                }
            }

            /// The newtype name under which serde carries a list of this element type; see [`Packed::NAME`].
            pub(crate) fn carrier(&self) -> &'static str {
                match self { $(Self::$variant(_) => <$element as Packed>::NAME,)+ }
            }

            /// The numbers that serde carried under a newtype name; `None` if the name belongs to no packed list.
            pub(crate) fn from_carrier(name: &str, bytes: &[u8]) -> Option<Self> {
                match name {
                    $($name => <$element as Packed>::unpack(bytes).map(Self::$variant),)+
                    _ => None,
                }
            }

            /// The shape of one element.
            pub(crate) fn shape(&self) -> Shape {
                match self { $(Self::$variant(_) => Shape::$variant,)+ }
            }

            /// Size of one element in bytes.
            pub(crate) fn size(&self) -> usize {
                match self { $(Self::$variant(_) => size_of::<$element>(),)+ }
            }

            /// Size in bytes of an element of this shape; `None` if lists of it are not packed.
            pub(crate) fn size_of(shape: &Shape) -> Option<usize> {
                Self::from_shape(shape, &[]).map(|none| none.size())
            }

            /// Converts little-endian bytes to numbers of this shape. Returns `None` if lists of it are not packed, or
            /// if the length is not a multiple of the element size.
            pub(crate) fn from_shape(shape: &Shape, bytes: &[u8]) -> Option<Self> {
                match shape {
                    $(Shape::$variant => <$element as Packed>::unpack(bytes).map(Self::$variant),)+
                    Shape::Any
                    | Shape::Bool
                    | Shape::U8
                    | Shape::U64
                    | Shape::Text
                    | Shape::Option(_)
                    | Shape::List(_)
                    | Shape::Array(..)
                    | Shape::Record(_) => None,
                }
            }

            /// Rust's name of the element type.
            pub fn element(&self) -> &'static str {
                match self { $(Self::$variant(_) => stringify!($element),)+ }
            }
        }

        $(impl Packed for $element {
            const NAME: &'static str = $name;

            fn append(all: &[Self], bytes: &mut Vec<u8>) {
                let start = bytes.len();
                bytes.resize(start + size_of_val(all), 0);
                // in one block, and not element by element, whose bytes the compiler does not join
                let (chunks, _) = bytes[start..].as_chunks_mut();
                for (chunk, one) in chunks.iter_mut().zip(all) {
                    *chunk = one.to_le_bytes();
                }
            }

            fn unpack<C: FromIterator<Self>>(bytes: &[u8]) -> Option<C> {
                let (elements, rest) = bytes.as_chunks();
                rest.is_empty()
                    .then(|| elements.iter().map(|one| Self::from_le_bytes(*one)).collect())
            }
        })+
    };
}

numbers! {
    /// 8-bit signed integers, as in an occupancy grid.
    I8(i8) = "datum::i8", tag 72, Int(i64);
    /// 16-bit signed integers.
    I16(i16) = "datum::i16", tag 77, Int(i64);
    /// 16-bit unsigned integers.
    U16(u16) = "datum::u16", tag 69, Int(i64);
    /// 32-bit signed integers.
    I32(i32) = "datum::i32", tag 78, Int(i64);
    /// 32-bit unsigned integers.
    U32(u32) = "datum::u32", tag 70, Int(i64);
    /// 64-bit signed integers.
    I64(i64) = "datum::i64", tag 79, Int(i64);
    /// Single-precision floats, as in a laser scan.
    F32(f32) = "datum::f32", tag 85, Float(f64);
    /// Double-precision floats, as in a covariance.
    F64(f64) = "datum::f64", tag 86, Float(f64);
}

impl Numbers {
    /// Returns whether there are no elements.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Iterates over the elements as datums.
    pub fn iter(&self) -> impl Iterator<Item = Datum> + '_ {
        (0..self.len()).filter_map(|index| self.get(index))
    }
}

/// A number that packs into little-endian bytes.
pub(crate) trait Packed: Sized {
    /// The newtype name that identifies a packed byte string to this crate's serialisers.
    const NAME: &'static str;

    /// Appends the elements to bytes.
    fn append(all: &[Self], bytes: &mut Vec<u8>);

    fn pack(all: &[Self]) -> Vec<u8> {
        let mut bytes = Vec::new();
        Self::append(all, &mut bytes);
        bytes
    }

    /// Returns `None` if the length is not a multiple of the element size.
    fn unpack<C: FromIterator<Self>>(bytes: &[u8]) -> Option<C>;
}

/// Bytes are packed already.
impl Packed for u8 {
    const NAME: &'static str = "datum::u8";

    fn append(all: &[Self], bytes: &mut Vec<u8>) {
        bytes.extend_from_slice(all);
    }

    fn unpack<C: FromIterator<Self>>(bytes: &[u8]) -> Option<C> {
        Some(bytes.iter().copied().collect())
    }
}
