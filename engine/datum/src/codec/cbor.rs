//! CBOR (RFC 8949), for machines: numeric arrays are typed arrays (RFC 8746), records are maps with text keys.
//!
//! Encoding is deterministic: equal datums give equal bytes (definite lengths, shortest integers, 64-bit floats,
//! entries in their own order), so the encoded form can be hashed.

mod tag;

use std::borrow::Cow;
use std::fmt::Display;
use std::sync::Arc;

use cbor4ii::core::dec::{self, Decode, Read};
use cbor4ii::core::enc::{self, Encode};
use cbor4ii::core::utils::{BufWriter, SliceReader};
use cbor4ii::core::{major, marker, types};
use serde::Serialize;
use serde::de::DeserializeOwned;

use super::DEPTH;
use crate::error::{DatumError, DatumProblem, repeated_name};
use crate::value::{Datum, FieldName, repeated};

/// Tag of a reference to shared memory: `[offset, length]` in place of a byte string.
pub const SHARED_TAG: u64 = 6_386_541;

/// Stores the content of a byte string elsewhere and returns its offset there; `None` to encode it in place.
pub type StoreBytes<'f> = dyn FnMut(&[u8]) -> Option<u64> + 'f;

/// Fetches a byte string of which only the offset and the length have been encoded; an error is its reason.
pub type FetchBytes<'f> = dyn FnMut(u64, u64) -> Result<Arc<[u8]>, String> + 'f;

/// Appends a datum, whose byte strings and packed numbers may be kept elsewhere, to bytes.
///
/// # Errors
/// The allocator has no memory for it.
pub fn append(
    datum: &Datum,
    to: &mut Vec<u8>,
    store: &mut StoreBytes<'_>,
) -> Result<(), DatumError> {
    let mut writer = BufWriter::new(std::mem::take(to));
    let written = write(datum, &mut writer, store);
    *to = writer.into_inner();
    written.map_err(malformed)
}

/// Decodes one datum, of which byte strings and packed numbers may be kept elsewhere.
///
/// # Errors
/// As for [`decode`], and the reasons of `fetch`.
pub fn decode_apart(bytes: &[u8], fetch: &mut FetchBytes<'_>) -> Result<Datum, DatumError> {
    read_all(bytes, &mut Some(fetch))
}

/// Encodes any serde value as CBOR.
///
/// # Errors
/// The value has no form as a datum: an integer beyond 64 bits, or a map whose keys are not text.
pub fn encode<T: Serialize + ?Sized>(value: &T) -> Result<Vec<u8>, DatumError> {
    let mut writer = BufWriter::new(Vec::new());
    write(&Datum::of(value)?, &mut writer, &mut |_| None).map_err(malformed)?;
    Ok(writer.into_inner())
}

/// Decodes any serde value from CBOR.
///
/// # Errors
/// [`DatumProblem::Malformed`](crate::DatumProblem::Malformed) if the bytes are not exactly one CBOR item;
/// [`DatumProblem::Mismatch`](crate::DatumProblem::Mismatch), with its path, if the data does not fit the type.
pub fn decode<T: DeserializeOwned>(bytes: &[u8]) -> Result<T, DatumError> {
    read_whole(bytes)?.to()
}

/// Decodes one datum; further bytes after it are an error.
pub(super) fn read_whole(bytes: &[u8]) -> Result<Datum, DatumError> {
    read_all(bytes, &mut None)
}

/// The way to byte strings that are kept elsewhere, if there is one.
type Apart<'f, 'g> = Option<&'f mut FetchBytes<'g>>;

fn read_all(bytes: &[u8], apart: &mut Apart<'_, '_>) -> Result<Datum, DatumError> {
    let mut reader = SliceReader::new(bytes);
    let datum = read(&mut reader, DEPTH, apart)?;
    let rest = reader.fill(1).map_err(malformed)?;
    if !rest.as_ref().is_empty() {
        return Err(malformed("trailing bytes"));
    }
    Ok(datum)
}

fn malformed(reason: impl ToString) -> DatumError {
    DatumError::new(DatumProblem::Malformed {
        codec: "CBOR",
        reason: reason.to_string(),
    })
}

/// Adds the place to an error, unless it has too many.
fn placed(error: DatumError, segment: impl Display) -> DatumError {
    match error.problem {
        DatumProblem::TooDeep(_) => error,
        DatumProblem::Mismatch(_)
        | DatumProblem::Implausible(_)
        | DatumProblem::IntegerTooBig(_)
        | DatumProblem::KeyNotText
        | DatumProblem::Malformed { .. }
        | DatumProblem::Uncarried { .. } => error.within(segment),
    }
}

type EncodeResult<W> = Result<(), enc::Error<<W as enc::Write>::Error>>;

fn write<W: enc::Write>(
    datum: &Datum,
    writer: &mut W,
    store: &mut StoreBytes<'_>,
) -> EncodeResult<W> {
    match datum {
        Datum::Null => types::Null.encode(writer),
        Datum::Bool(value) => value.encode(writer),
        Datum::Int(value) => value.encode(writer),
        Datum::Float(value) => value.encode(writer),
        Datum::Text(value) => value.as_str().encode(writer),
        Datum::Bytes(bytes) => write_bytes(bytes, writer, store),
        Datum::Numbers(numbers) => {
            types::Tag(numbers.tag(), types::Nothing).encode(writer)?;
            write_bytes(&numbers.to_bytes(), writer, store)
        }
        Datum::List(elements) => {
            types::Array::bounded(elements.len(), writer)?;
            elements
                .iter()
                .try_for_each(|element| write(element, writer, store))
        }
        Datum::Record(entries) => {
            types::Map::bounded(entries.len(), writer)?;
            entries.iter().try_for_each(|(name, value)| {
                name.as_ref().encode(writer)?;
                write(value, writer, store)
            })
        }
    }
}

fn write_bytes<W: enc::Write>(
    bytes: &[u8],
    writer: &mut W,
    store: &mut StoreBytes<'_>,
) -> EncodeResult<W> {
    let Some(offset) = store(bytes) else {
        return types::Bytes(bytes).encode(writer);
    };
    types::Tag(SHARED_TAG, types::Nothing).encode(writer)?;
    types::Array::bounded(2, writer)?;
    offset.encode(writer)?;
    (bytes.len() as u64).encode(writer)
}

/// Reads one datum that may nest `depth` levels deep.
fn read(
    reader: &mut SliceReader<'_>,
    depth: usize,
    apart: &mut Apart<'_, '_>,
) -> Result<Datum, DatumError> {
    let Some(depth) = depth.checked_sub(1) else {
        return Err(DatumError::new(DatumProblem::TooDeep(DEPTH)));
    };
    let first = peek(reader)?;
    match dec::if_major(first) {
        major::UNSIGNED => tag::unsigned(u64::decode(reader).map_err(malformed)?),
        major::NEGATIVE => {
            let types::Negative(n) = types::Negative::<u64>::decode(reader).map_err(malformed)?;
            tag::negative(n)
        }
        major::BYTES => Ok(Datum::Bytes(bytes(reader)?.as_ref().into())),
        major::STRING => text(reader).map(|text| Datum::Text(text.into_owned())),
        major::ARRAY => list(reader, depth, apart),
        major::MAP => record(reader, depth, apart),
        major::TAG => tagged(reader, depth, apart),
        _simple => simple(reader, first),
    }
}

fn peek(reader: &mut SliceReader<'_>) -> Result<u8, DatumError> {
    let ahead = reader.fill(1).map_err(malformed)?;
    ahead
        .as_ref()
        .first()
        .copied()
        .ok_or_else(|| malformed("unexpected end"))
}

fn bytes<'de>(reader: &mut SliceReader<'de>) -> Result<Cow<'de, [u8]>, DatumError> {
    types::Bytes::<Cow<'de, [u8]>>::decode(reader)
        .map(|bytes| bytes.0)
        .map_err(malformed)
}

fn text<'de>(reader: &mut SliceReader<'de>) -> Result<Cow<'de, str>, DatumError> {
    Cow::<'de, str>::decode(reader).map_err(malformed)
}

/// Reads the announced number of items, or all up to the break of an indefinite-length item (RFC 8949 §3.2).
fn each(
    reader: &mut SliceReader<'_>,
    announced: Option<usize>,
    mut one: impl FnMut(&mut SliceReader<'_>) -> Result<(), DatumError>,
) -> Result<(), DatumError> {
    match announced {
        Some(count) => (0..count).try_for_each(|_| one(reader)),
        None => {
            while !dec::is_break(reader).map_err(malformed)? {
                one(reader)?;
            }
            Ok(())
        }
    }
}

fn list(
    reader: &mut SliceReader<'_>,
    depth: usize,
    apart: &mut Apart<'_, '_>,
) -> Result<Datum, DatumError> {
    let announced = types::Array::len(reader).map_err(malformed)?;
    let mut elements = Vec::new();
    each(reader, announced, |reader| {
        let element = read(reader, depth, apart);
        elements.push(element.map_err(|error| placed(error, elements.len()))?);
        Ok(())
    })?;
    Ok(Datum::List(elements))
}

fn record(
    reader: &mut SliceReader<'_>,
    depth: usize,
    apart: &mut Apart<'_, '_>,
) -> Result<Datum, DatumError> {
    let announced = types::Map::len(reader).map_err(malformed)?;
    let mut entries: Vec<(FieldName, Datum)> = Vec::new();
    each(reader, announced, |reader| {
        if dec::if_major(peek(reader)?) != major::STRING {
            return Err(DatumError::new(DatumProblem::KeyNotText));
        }
        let name = text(reader)?.into_owned();
        let value = read(reader, depth, apart).map_err(|error| placed(error, &name))?;
        entries.push((name.into(), value));
        Ok(())
    })?;
    match repeated(&entries) {
        Some(name) => Err(repeated_name(name)),
        None => Ok(Datum::Record(entries)),
    }
}

/// Reads a tagged item: a typed array (RFC 8746) becomes packed numbers. A tag that leaves the meaning of its content as it is,
/// such as that of a date, is ignored.
fn tagged(
    reader: &mut SliceReader<'_>,
    depth: usize,
    apart: &mut Apart<'_, '_>,
) -> Result<Datum, DatumError> {
    let tag = types::Tag::tag(reader).map_err(malformed)?;
    let content = read(reader, depth, apart)?;
    if tag == SHARED_TAG
        && let Some(fetch) = apart
    {
        return fetched(&content, fetch);
    }
    tag::interpreted(tag, &content).unwrap_or(Ok(content))
}

/// Fetches a byte string by its reference.
fn fetched(reference: &Datum, fetch: &mut FetchBytes<'_>) -> Result<Datum, DatumError> {
    let Datum::List(parts) = reference else {
        return Err(malformed("a reference to shared memory is not a list"));
    };
    if let [Datum::Int(offset), Datum::Int(length)] = parts.as_slice()
        && let (Ok(offset), Ok(length)) = (u64::try_from(*offset), u64::try_from(*length))
    {
        return fetch(offset, length).map(Datum::Bytes).map_err(malformed);
    }
    let problem = "a reference to shared memory is not an offset and a length";
    Err(malformed(problem))
}

fn simple(reader: &mut SliceReader<'_>, first: u8) -> Result<Datum, DatumError> {
    match first {
        marker::FALSE | marker::TRUE => bool::decode(reader).map(Datum::Bool).map_err(malformed),
        marker::NULL | marker::UNDEFINED => {
            reader.advance(1);
            Ok(Datum::Null)
        }
        marker::F16 => types::F16::decode(reader)
            .map(|types::F16(bits)| Datum::Float(tag::half(bits).into()))
            .map_err(malformed),
        marker::F32 => f32::decode(reader)
            .map(|value| Datum::Float(value.into()))
            .map_err(malformed),
        marker::F64 => f64::decode(reader).map(Datum::Float).map_err(malformed),
        other => Err(malformed(format_args!("unknown initial byte {other:#04x}"))),
    }
}
