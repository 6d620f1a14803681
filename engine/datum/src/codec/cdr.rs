//! CDR (OMG XCDR1, as DDS and ROS 2 write it), for those whose messages are ROS messages.
//!
//! Nothing of it says what it is: writing and reading follow a schema. A value stands at a multiple of its own size,
//! counted from the end of the four bytes that say in which order bytes stand. We write the little end first, and read
//! both.

mod read;
mod write;

use super::DEPTH;
use crate::error::{DatumError, DatumProblem};
use crate::message::Message;
use crate::schema::{Schema, Shape};

pub(super) use read::read_whole;
pub(super) use write::write_whole;

/// What comes first: CDR, little end first, no options.
const LITTLE: [u8; 4] = [0, 1, 0, 0];
/// CDR, big end first.
const BIG: [u8; 4] = [0, 0, 0, 0];

/// A message as CDR.
pub fn encode<T: Message>(message: &T) -> Result<Vec<u8>, DatumError> {
    write_whole(&crate::value::Datum::of(message)?, T::schema())
}

/// A message from CDR.
pub fn decode<T: Message>(bytes: &[u8]) -> Result<T, DatumError> {
    read_whole(bytes, T::schema())?.to()
}

/// Says what of a shape CDR cannot carry, if anything: what is known at run time only, and arrays without elements.
/// What may be absent is a sequence of at most one, as ROS 2 writes it (`T[<=1]`); a message without fields is one byte.
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
        Shape::Any | Shape::Array(_, 0) => Err(shapeless(schema)),
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

/// There is no CDR of this.
fn shapeless(schema: &Schema) -> DatumError {
    DatumError::new(DatumProblem::Uncarried {
        codec: "CDR",
        shape: match (&schema.shape, schema.name.is_empty()) {
            (Shape::Any, true) => "what is known at run time only".to_owned(),
            (Shape::Any, false) => format!("`{schema}`, of which only the name is known"),
            (_, _) => format!("`{schema}`"),
        },
    })
}

fn malformed(reason: impl ToString) -> DatumError {
    DatumError::new(DatumProblem::Malformed {
        codec: "CDR",
        reason: reason.to_string(),
    })
}
