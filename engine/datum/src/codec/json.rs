//! JSON, for human readers: exact floats; the floats that JSON lacks are written `"NaN"`, `"Infinity"` and
//! `"-Infinity"`.

use serde::de::DeserializeOwned;
use serde::ser::{Serialize, Serializer};

use crate::error::{DatumError, DatumProblem, repeated_name};
use crate::value::{Datum, repeated};

/// Encodes any serde value as JSON on one line.
///
/// # Errors
/// The value has no form as a datum: an integer beyond 64 bits, or a map whose keys are not text.
pub fn encode<T: Serialize + ?Sized>(value: &T) -> Result<String, DatumError> {
    serde_json::to_string(&JsonDatum(&Datum::of(value)?)).map_err(malformed)
}

/// Encodes a datum as JSON on one line.
///
/// # Errors
/// None in practice: all data have a form as JSON.
pub fn encode_datum(datum: &Datum) -> Result<String, DatumError> {
    serde_json::to_string(&JsonDatum(datum)).map_err(malformed)
}

/// Encodes any serde value as indented JSON.
///
/// # Errors
/// As [`encode`].
pub fn encode_pretty<T: Serialize + ?Sized>(value: &T) -> Result<String, DatumError> {
    serde_json::to_string_pretty(&JsonDatum(&Datum::of(value)?)).map_err(malformed)
}

/// Decodes any serde value from JSON.
///
/// # Errors
/// The text is not exactly one JSON value, or its data does not fit the type; then the error has the path.
pub fn decode<T: DeserializeOwned>(text: &str) -> Result<T, DatumError> {
    read_whole(text.as_bytes())?.to()
}

/// Decodes one datum from JSON in UTF-8. The parser limits the nesting depth itself.
pub(super) fn read_whole(text: &[u8]) -> Result<Datum, DatumError> {
    let datum = serde_json::from_slice(text).map_err(malformed)?;
    check_names(&datum)?;
    Ok(datum)
}

/// Checks that no record has two entries of one name, which programs read differently (RFC 8259 §4).
fn check_names(datum: &Datum) -> Result<(), DatumError> {
    match datum {
        Datum::Record(entries) => {
            if let Some(name) = repeated(entries) {
                return Err(repeated_name(name));
            }
            let mut entries = entries.iter();
            entries.try_for_each(|(name, value)| {
                check_names(value).map_err(|error| error.within(name))
            })
        }
        Datum::List(elements) => {
            let mut elements = elements.iter().enumerate();
            elements.try_for_each(|(index, element)| {
                check_names(element).map_err(|error| error.within(index))
            })
        }
        Datum::Null
        | Datum::Bool(_)
        | Datum::Int(_)
        | Datum::Float(_)
        | Datum::Text(_)
        | Datum::Bytes(_)
        | Datum::Numbers(_) => Ok(()),
    }
}

fn malformed(error: serde_json::Error) -> DatumError {
    DatumError::new(DatumProblem::Malformed {
        codec: "JSON",
        reason: error.to_string(),
    })
}

/// Serialises a datum with the replacements for special floats.
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

/// Serialises one element of packed numbers, which has to be created first.
struct OwnedJsonDatum(Datum);

impl Serialize for OwnedJsonDatum {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        JsonDatum(&self.0).serialize(serializer)
    }
}
