//! CDR (OMG XCDR1, as in DDS and ROS 2), for the exchange with programs that use ROS messages.
//!
//! CDR is not self-describing: writing and reading follow a schema. Each value is aligned to a multiple of its own
//! size, counted from the end of the four-byte encapsulation header, which specifies the byte order. We write
//! little-endian, and read both orders.

mod read;
mod write;

use super::DEPTH;
use crate::error::{DatumError, DatumProblem};
use crate::message::Message;
use crate::schema::{Schema, Shape};

pub(super) use read::{read_ros1, read_whole};
pub(super) use write::{write_ros1, write_whole};

/// The encodings that follow a schema, with the same order of the same numbers.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Format {
    /// Aligned, after a header; strings are terminated, a message without fields is one byte.
    Cdr,
    /// Neither.
    Ros1,
}

impl Format {
    fn name(self) -> &'static str {
        match self {
            Self::Cdr => "CDR",
            Self::Ros1 => "the encoding of ROS 1",
        }
    }
}

/// The encapsulation header: plain CDR, little-endian, no options.
const LITTLE: [u8; 4] = [0, 1, 0, 0];
/// The encapsulation header of big-endian CDR.
const BIG: [u8; 4] = [0, 0, 0, 0];

/// Encodes a message as CDR.
///
/// # Errors
/// The value does not fit the schema of its type, or [`carries`] refuses the schema.
pub fn encode<T: Message>(message: &T) -> Result<Vec<u8>, DatumError> {
    write_whole(&crate::value::Datum::of(message)?, T::schema())
}

/// Decodes a message from CDR.
///
/// # Errors
/// The bytes end early or have a rest, the encapsulation header is unknown, or a text is not UTF-8; or [`carries`]
/// refuses the schema.
pub fn decode<T: Message>(bytes: &[u8]) -> Result<T, DatumError> {
    read_whole(bytes, T::schema())?.to()
}

/// Checks that CDR can encode data of this schema.
///
/// It cannot encode data of unknown schema, and arrays without elements. An optional value is a sequence of at most one
/// element, as ROS 2 defines it (`T[<=1]`); a message without fields is one byte.
///
/// # Errors
/// [`DatumProblem::Uncarried`](crate::DatumProblem::Uncarried) with the path of the first such place.
pub fn carries(schema: &Schema) -> Result<(), DatumError> {
    within(schema, DEPTH)
}

fn within(schema: &Schema, depth: usize) -> Result<(), DatumError> {
    let depth = deeper(depth)?;
    match &schema.shape {
        Shape::Bool
        | Shape::I8
        | Shape::I16
        | Shape::I32
        | Shape::I64
        | Shape::U8
        | Shape::U16
        | Shape::U32
        | Shape::U64
        | Shape::F32
        | Shape::F64
        | Shape::Text => Ok(()),
        Shape::Any | Shape::Array(_, 0) => Err(shapeless(Format::Cdr, schema)),
        Shape::Option(element) | Shape::List(element) | Shape::Array(element, _) => {
            within(element, depth).map_err(|error| error.within("*"))
        }
        Shape::Record(fields) => fields.iter().try_for_each(|field| {
            within(&field.schema, depth).map_err(|error| error.within(&field.name))
        }),
    }
}

fn deeper(depth: usize) -> Result<usize, DatumError> {
    depth
        .checked_sub(1)
        .ok_or_else(|| DatumError::new(DatumProblem::TooDeep(DEPTH)))
}

/// The error for a schema that the format cannot encode.
fn shapeless(format: Format, schema: &Schema) -> DatumError {
    DatumError::new(DatumProblem::Uncarried {
        codec: format.name(),
        shape: match (&schema.shape, schema.name.is_empty()) {
            (Shape::Any, true) => "a type known only at run time".to_owned(),
            (Shape::Any, false) => format!("`{schema}`, whose fields are unknown"),
            (_, _) => format!("`{schema}`"),
        },
    })
}

fn malformed(format: Format, reason: impl ToString) -> DatumError {
    DatumError::new(DatumProblem::Malformed {
        codec: format.name(),
        reason: reason.to_string(),
    })
}
