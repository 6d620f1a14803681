//! Codecs: a datum to bytes and back. A codec is one file, and one row in [`Codec`].

pub mod cbor;
pub mod cdr;
pub mod json;

use crate::error::DatumError;
use crate::schema::Schema;
use crate::value::Datum;

/// How a payload is written; named by its content type.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, serde::Serialize, asmotion_derive::Word)]
#[serde(rename_all = "snake_case")]
pub enum Codec {
    /// Compact, exact, numeric arrays packed: for machines.
    #[default]
    Cbor,
    /// Exact floats, `"NaN"` and `"Infinity"` as text: for people.
    Json,
    /// As ROS 2 and DDS write it: only with the schema at hand.
    Cdr,
}

impl Codec {
    /// Every codec.
    pub const ALL: [Self; 3] = [Self::Cbor, Self::Json, Self::Cdr];

    /// The content type, as messages declare it.
    pub fn content_type(self) -> &'static str {
        match self {
            Self::Cbor => "application/cbor",
            Self::Json => "application/json",
            Self::Cdr => "application/cdr",
        }
    }

    /// The codec of a content type, if there is one.
    pub fn of_content_type(content_type: &str) -> Option<Self> {
        Self::ALL
            .into_iter()
            .find(|codec| codec.content_type() == content_type)
    }

    /// Writes a datum. What does not describe itself, follows the schema.
    pub fn encode(self, datum: &Datum, schema: &Schema) -> Result<Vec<u8>, DatumError> {
        match self {
            Self::Cbor => cbor::encode(datum),
            Self::Json => json::encode(datum).map(String::into_bytes),
            Self::Cdr => cdr::write_whole(datum, schema),
        }
    }

    /// Reads a datum. What does not describe itself, follows the schema; the rest says what it is.
    pub fn decode(self, bytes: &[u8], schema: &Schema) -> Result<Datum, DatumError> {
        match self {
            Self::Cbor => cbor::read_whole(bytes),
            Self::Json => json::read_whole(bytes),
            Self::Cdr => cdr::read_whole(bytes, schema),
        }
    }

    /// Says what of a shape this codec cannot carry, if anything.
    pub fn carries(self, schema: &Schema) -> Result<(), DatumError> {
        match self {
            Self::Cbor | Self::Json => Ok(()),
            Self::Cdr => cdr::carries(schema),
        }
    }
}

/// How deep data may nest before a reader refuses it.
const DEPTH: usize = 64;

/// The numbers that JSON cannot write, as it writes them here.
pub(crate) fn special_float(text: &str) -> Option<f64> {
    match text {
        "NaN" => Some(f64::NAN),
        "Infinity" => Some(f64::INFINITY),
        "-Infinity" => Some(f64::NEG_INFINITY),
        _ => None,
    }
}
