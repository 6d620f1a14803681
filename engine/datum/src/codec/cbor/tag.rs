//! Tagged items of senders in any language: typed arrays (RFC 8746) of every width and byte order, and large integers.
//!
//! A tag changes the meaning of its content. Content whose tag is known and cannot be represented is refused: read without its
//! tag, a typed array would be a list of single bytes.

use std::sync::Arc;

use crate::error::{DatumError, DatumProblem};
use crate::numbers::Numbers;
use crate::value::Datum;

/// Reads the content of a tag. Returns `None` if the tag leaves the meaning of its content as it is.
pub(super) fn interpreted(tag: u64, content: &Datum) -> Option<Result<Datum, DatumError>> {
    match tag {
        2 | 3 => Some(large_integer(tag == 3, content)),
        4 | 5 | 30 => Some(refused(tag, "a fraction of integers")),
        40 | 1040 => Some(refused(tag, "an array of several dimensions")),
        64..=87 => Some(typed_array(tag, content)),
        _ => None,
    }
}

/// 2 to the power of -24.
const SMALLEST_HALF: f32 = f32::from_bits(0x3380_0000);

/// Floats of half precision are signed, with five bits of exponent and ten of mantissa (RFC 8949, appendix D). Each is a float of
/// single precision exactly.
pub(super) fn half(bits: u16) -> f32 {
    let (exponent, mantissa) = (u32::from(bits >> 10 & 0x1f), u32::from(bits & 0x3ff));
    let magnitude = match exponent {
        0 => f32::from(bits & 0x3ff) * SMALLEST_HALF,
        31 if mantissa == 0 => f32::INFINITY,
        31 => f32::NAN,
        exponent => f32::from_bits((exponent + 112) << 23 | mantissa << 13),
    };
    if bits >> 15 == 1 {
        -magnitude
    } else {
        magnitude
    }
}

/// The value of -1 - n, the meaning of negative integers in CBOR.
pub(super) fn negative(n: u64) -> Result<Datum, DatumError> {
    let value = -1 - i128::from(n);
    i64::try_from(value)
        .map(Datum::Int)
        .map_err(|_| too_big(value))
}

pub(super) fn unsigned(value: u64) -> Result<Datum, DatumError> {
    i64::try_from(value)
        .map(Datum::Int)
        .map_err(|_| too_big(value))
}

fn too_big(value: impl ToString) -> DatumError {
    DatumError::new(DatumProblem::IntegerTooBig(value.to_string()))
}

fn malformed(reason: String) -> DatumError {
    let codec = "CBOR";
    DatumError::new(DatumProblem::Malformed { codec, reason })
}

fn refused(tag: u64, meaning: &str) -> Result<Datum, DatumError> {
    Err(malformed(format!(
        "the tag {tag}, {meaning}, is not supported"
    )))
}

/// Big-endian bytes of an integer of any size (RFC 8949 §3.4.3).
fn large_integer(is_negative: bool, content: &Datum) -> Result<Datum, DatumError> {
    let Datum::Bytes(bytes) = content else {
        let reason = format!("a large integer is a byte string, found {}", content.kind());
        return Err(malformed(reason));
    };
    let leading = bytes.iter().take_while(|byte| **byte == 0).count();
    let digits = bytes.get(leading..).unwrap_or_default();
    if digits.len() > size_of::<u64>() {
        return Err(too_big(format_args!("of {} bytes", digits.len())));
    }
    let magnitude = digits
        .iter()
        .fold(0, |value, byte| value << 8 | u64::from(*byte));
    if is_negative {
        negative(magnitude)
    } else {
        unsigned(magnitude)
    }
}

/// The lower five bits of a typed array's tag: `f` float, `s` signed, `e` little-endian, and two bits `ll` of the width, which is
/// `1 << (f + ll)` bytes (RFC 8746 §2.1). Tags of single bytes use `e` otherwise: 68 is `u8` with clamped arithmetic.
fn typed_array(tag: u64, content: &Datum) -> Result<Datum, DatumError> {
    let Datum::Bytes(bytes) = content else {
        return Err(malformed(format!(
            "the tag {tag}, a typed array, needs a byte string, found {}",
            content.kind()
        )));
    };
    let is_float = tag & 0x10 != 0;
    let width = 1_usize << (u64::from(is_float) + (tag & 3));
    if width == 16 {
        return refused(tag, "a typed array of 128-bit floats");
    }
    if !bytes.len().is_multiple_of(width) {
        return Err(malformed(format!(
            "the tag {tag}, a typed array with elements of {width} bytes, has {} bytes",
            bytes.len()
        )));
    }
    let is_little = width == 1 || tag & 4 != 0;
    let bytes = if is_little {
        Arc::clone(bytes)
    } else {
        swapped(bytes, width)
    };
    match tag | 4 {
        68 if width == 1 => Ok(Datum::Bytes(bytes)),
        71 => unsigned_array(&bytes),
        76 if tag == 76 => refused(tag, "which is reserved"),
        76 => packed(72, &bytes),
        84 => Ok(Datum::Numbers(Numbers::F32(
            pairs(&bytes).map(half).collect(),
        ))),
        little => packed(little, &bytes),
    }
}

fn packed(tag: u64, bytes: &[u8]) -> Result<Datum, DatumError> {
    let numbers = Numbers::from_tagged(tag, bytes).map(Datum::Numbers);
    numbers.map_or_else(|| refused(tag, "a typed array"), Ok)
}

/// Elements in the other byte order.
fn swapped(bytes: &[u8], width: usize) -> Arc<[u8]> {
    let elements = bytes.chunks_exact(width);
    elements.flat_map(|one| one.iter().rev().copied()).collect()
}

fn pairs(bytes: &[u8]) -> impl Iterator<Item = u16> + '_ {
    let (pairs, _) = bytes.as_chunks();
    pairs.iter().map(|pair| u16::from_le_bytes(*pair))
}

/// No packed list has elements of this type, because integers of a datum have a sign.
fn unsigned_array(bytes: &[u8]) -> Result<Datum, DatumError> {
    let (elements, _) = bytes.as_chunks();
    let elements = elements.iter().enumerate().map(|(index, element)| {
        unsigned(u64::from_le_bytes(*element)).map_err(|error| error.within(index))
    });
    elements.collect::<Result<_, _>>().map(Datum::List)
}
