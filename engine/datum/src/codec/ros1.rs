//! The encoding of messages in ROS 1: little-endian, without alignment, after the schema.
//!
//! Differences from CDR: no header and no alignment, strings have no terminating zero, and a message without fields has no
//! bytes. Fixed arrays have no length. An optional value is a sequence of at most one element, as in CDR.
//!
//! Source: the ROS wiki, "Technical Overview" and "msg", section *Fields*.

use super::cdr::{read_ros1, write_ros1};
use crate::error::{DatumError, DatumProblem};
use crate::schema::Schema;
use crate::value::Datum;

/// Bytes of the length that precedes a message on a connection.
const LENGTH: usize = 4;

/// Bytes of a small message with its length, such as a pose with a header, which is encoded without another allocation.
const SMALL: usize = 128;

/// Encodes a datum, without the length that precedes a message on a connection.
///
/// # Errors
/// The datum does not fit the schema, or a part of the schema is unknown.
pub fn encode(datum: &Datum, schema: &Schema) -> Result<Vec<u8>, DatumError> {
    write_ros1(datum, schema, Vec::new())
}

/// Encodes a datum, with the length that precedes a message on a connection.
///
/// # Errors
/// As [`encode`], or the message has more bytes than 32 bits can count.
pub fn encode_frame(datum: &Datum, schema: &Schema) -> Result<Vec<u8>, DatumError> {
    let mut frame = Vec::with_capacity(SMALL);
    frame.extend_from_slice(&[0; LENGTH]);
    let mut frame = write_ros1(datum, schema, frame)?;
    let length = frame.len() - LENGTH;
    let length = u32::try_from(length).map_err(|_| {
        let reason = format!("{length} bytes are more than 32 bits can count");
        DatumError::new(DatumProblem::Mismatch(reason))
    })?;
    frame[..LENGTH].copy_from_slice(&length.to_le_bytes());
    Ok(frame)
}

/// Decodes a datum.
///
/// # Errors
/// The bytes end early or have a rest, a text is not UTF-8, or a part of the schema is unknown.
pub fn decode(bytes: &[u8], schema: &Schema) -> Result<Datum, DatumError> {
    read_ros1(bytes, schema)
}
