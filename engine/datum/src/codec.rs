//! Codecs: a datum to bytes and back. A codec is one file, and one row in [`Codec`].

pub mod cbor;
pub mod json;

use crate::{Datum, DatumError};

/// How a payload is written; named by its content type.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Codec {
    /// Compact, exact, numeric arrays packed: for machines.
    #[default]
    Cbor,
    /// Exact floats, `"NaN"` and `"Infinity"` as text: for people.
    Json,
}

impl Codec {
    /// The content type, as messages declare it.
    pub fn content_type(self) -> &'static str {
        match self {
            Self::Cbor => "application/cbor",
            Self::Json => "application/json",
        }
    }

    /// The codec of a content type, if there is one.
    pub fn of_content_type(content_type: &str) -> Option<Self> {
        [Self::Cbor, Self::Json]
            .into_iter()
            .find(|codec| codec.content_type() == content_type)
    }

    /// Writes a datum.
    pub fn encode(self, datum: &Datum) -> Result<Vec<u8>, DatumError> {
        match self {
            Self::Cbor => cbor::encode(datum),
            Self::Json => json::encode(datum).map(String::into_bytes),
        }
    }

    /// Reads a datum.
    pub fn decode(self, bytes: &[u8]) -> Result<Datum, DatumError> {
        match self {
            Self::Cbor => cbor::read_whole(bytes),
            Self::Json => json::read_whole(bytes),
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
