//! JSON, for people: exact floats; the numbers JSON lacks as `"NaN"`, `"Infinity"`, `"-Infinity"`.

use serde::de::DeserializeOwned;
use serde::ser::{Serialize, Serializer};

use crate::error::{DatumError, DatumProblem};
use crate::value::Datum;

/// Any serde value as JSON text on one line.
pub fn encode<T: Serialize + ?Sized>(value: &T) -> Result<String, DatumError> {
    serde_json::to_string(&JsonDatum(&Datum::of(value)?)).map_err(malformed)
}

/// Any serde value as indented JSON text.
pub fn encode_pretty<T: Serialize + ?Sized>(value: &T) -> Result<String, DatumError> {
    serde_json::to_string_pretty(&JsonDatum(&Datum::of(value)?)).map_err(malformed)
}

/// Any serde value from JSON text.
pub fn decode<T: DeserializeOwned>(text: &str) -> Result<T, DatumError> {
    read_whole(text.as_bytes())?.to()
}

/// One datum from JSON text in UTF-8. The parser bounds the depth itself.
pub(super) fn read_whole(text: &[u8]) -> Result<Datum, DatumError> {
    serde_json::from_slice(text).map_err(malformed)
}

fn malformed(error: serde_json::Error) -> DatumError {
    DatumError::new(DatumProblem::Malformed {
        codec: "JSON",
        reason: error.to_string(),
    })
}

/// A datum as JSON wants it written.
struct JsonDatum<'a>(&'a Datum);

impl Serialize for JsonDatum<'_> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match self.0 {
            Datum::Float(value) if value.is_nan() => serializer.serialize_str("NaN"),
            Datum::Float(value) if value.is_infinite() && *value > 0.0 => {
                serializer.serialize_str("Infinity")
            }
            Datum::Float(value) if value.is_infinite() => serializer.serialize_str("-Infinity"),
            Datum::List(elements) => serializer.collect_seq(elements.iter().map(JsonDatum)),
            Datum::Numbers(numbers) => serializer.collect_seq(numbers.iter().map(OwnedJsonDatum)),
            Datum::Record(entries) => {
                serializer.collect_map(entries.iter().map(|(name, value)| (name, JsonDatum(value))))
            }
            Datum::Null
            | Datum::Bool(_)
            | Datum::Int(_)
            | Datum::Float(_)
            | Datum::Text(_)
            | Datum::Bytes(_) => self.0.serialize(serializer),
        }
    }
}

/// One of a run of packed numbers.
struct OwnedJsonDatum(Datum);

impl Serialize for OwnedJsonDatum {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        JsonDatum(&self.0).serialize(serializer)
    }
}
