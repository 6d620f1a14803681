//! Codecs: a datum to bytes and back. Each codec is a module and a variant of [`Codec`].

pub mod cbor;
pub mod cdr;
pub mod json;
pub mod ros1;

use crate::error::DatumError;
use crate::schema::Schema;
use crate::value::Datum;

/// The encoding of a payload, identified by its content type.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, serde::Serialize, asmotion_derive::Word)]
#[serde(rename_all = "snake_case")]
pub enum Codec {
    /// CBOR: compact, exact, with packed numeric arrays; for machines.
    #[default]
    Cbor,
    /// JSON: exact floats, with `"NaN"` and `"Infinity"` as strings; for human readers.
    Json,
    /// CDR, as used by ROS 2 and DDS; readable only with the schema.
    Cdr,
}

impl Codec {
    /// All codecs.
    pub const ALL: [Self; 3] = [Self::Cbor, Self::Json, Self::Cdr];

    /// The content type, as in message headers.
    pub fn content_type(self) -> &'static str {
        match self {
            Self::Cbor => "application/cbor",
            Self::Json => "application/json",
            Self::Cdr => "application/cdr",
        }
    }

    /// The codec with this content type.
    pub fn of_content_type(content_type: &str) -> Option<Self> {
        Self::ALL
            .into_iter()
            .find(|codec| codec.content_type() == content_type)
    }

    /// Encodes a datum. A codec that is not self-describing follows the schema.
    ///
    /// # Errors
    /// CDR only: the datum does not fit the schema, or the schema cannot be carried (see [`carries`](Self::carries)).
    pub fn encode(self, datum: &Datum, schema: &Schema) -> Result<Vec<u8>, DatumError> {
        match self {
            Self::Cbor => cbor::encode(datum),
            Self::Json => json::encode(datum).map(String::into_bytes),
            Self::Cdr => cdr::write_whole(datum, schema),
        }
    }

    /// Decodes a datum. A codec that is not self-describing follows the schema; the others ignore it.
    ///
    /// # Errors
    /// The bytes are malformed: cut short, followed by a rest, nested too deeply, or a record with a repeated name. CDR also refuses schemas that it
    /// cannot carry.
    pub fn decode(self, bytes: &[u8], schema: &Schema) -> Result<Datum, DatumError> {
        match self {
            Self::Cbor => cbor::read_whole(bytes),
            Self::Json => json::read_whole(bytes),
            Self::Cdr => cdr::read_whole(bytes, schema),
        }
    }

    /// Checks that the codec can encode data of this schema.
    ///
    /// # Errors
    /// The part that it cannot encode.
    pub fn carries(self, schema: &Schema) -> Result<(), DatumError> {
        match self {
            Self::Cbor | Self::Json => Ok(()),
            Self::Cdr => cdr::carries(schema),
        }
    }
}

/// Limit on the nesting depth of decoded data, to bound the stack.
const DEPTH: usize = 64;

/// The value of the texts that stand for floats which JSON cannot represent.
pub(crate) fn special_float(text: &str) -> Option<f64> {
    match text {
        "NaN" => Some(f64::NAN),
        "Infinity" => Some(f64::INFINITY),
        "-Infinity" => Some(f64::NEG_INFINITY),
        _ => None,
    }
}
