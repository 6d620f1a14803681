//! The subset of the protobuf wire format (<https://protobuf.dev/programming-guides/encoding/>) that OSM PBF needs.
//!
//! Reading copies nothing: a message is a slice, and each length is checked against the remaining bytes. No input can
//! cause a panic, or the allocation of more than a small multiple of its own size.

/// The reason that bytes are not a protobuf message.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum ProtobufError {
    /// A number or a length extends beyond the end.
    #[error("a message ends too early")]
    Truncated,
    /// A number has more than ten bytes, or a sum of differences more than 64 bits.
    #[error("a number has more than 64 bits")]
    TooLarge,
    /// Wire types 3 and 4 (groups) are obsolete, 6 and 7 are not defined.
    #[error("a field has the wire type {0}, which is not supported")]
    WireType(u64),
    /// A field has another type than in the schema.
    #[error("field {0} has an unexpected type")]
    OtherType(u64),
}

/// One field of a message.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ProtobufField<'a> {
    /// Number in the schema.
    pub number: u64,
    content: Content<'a>,
}

/// The content of a field, by wire type.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Content<'a> {
    /// An encoded number.
    Varint(&'a [u8]),
    /// A text, a nested message, or packed numbers.
    Bytes(&'a [u8]),
    /// Four or eight bytes, which no field of OSM PBF uses.
    Fixed,
}

/// The fields of a message, in order. Ends after the first error.
pub fn fields(message: &[u8]) -> impl Iterator<Item = Result<ProtobufField<'_>, ProtobufError>> {
    let mut rest = message;
    std::iter::from_fn(move || {
        if rest.is_empty() {
            return None;
        }
        let field = next_field(&mut rest);
        if field.is_err() {
            rest = &[];
        }
        Some(field)
    })
}

fn next_field<'a>(rest: &mut &'a [u8]) -> Result<ProtobufField<'a>, ProtobufError> {
    let key = take_varint(rest)?;
    let content = match key & 7 {
        0 => {
            let before = *rest;
            take_varint(rest)?;
            Content::Varint(&before[..before.len() - rest.len()])
        }
        1 => take(rest, 8).map(|_| Content::Fixed)?,
        2 => {
            let length = take_varint(rest)?;
            let length = usize::try_from(length).map_err(|_| ProtobufError::Truncated)?;
            Content::Bytes(take(rest, length)?)
        }
        5 => take(rest, 4).map(|_| Content::Fixed)?,
        other => return Err(ProtobufError::WireType(other)),
    };
    Ok(ProtobufField {
        number: key >> 3,
        content,
    })
}

fn take<'a>(rest: &mut &'a [u8], length: usize) -> Result<&'a [u8], ProtobufError> {
    let (taken, after) = rest
        .split_at_checked(length)
        .ok_or(ProtobufError::Truncated)?;
    *rest = after;
    Ok(taken)
}

/// Decodes a number: seven bits per byte, lowest first; the top bit is set if another byte follows.
fn take_varint(rest: &mut &[u8]) -> Result<u64, ProtobufError> {
    let mut value = 0;
    for (index, byte) in rest.iter().take(10).enumerate() {
        let bits = u64::from(byte & 0x7f);
        if index == 9 && bits > 1 {
            return Err(ProtobufError::TooLarge);
        }
        value |= bits << (7 * index);
        if byte & 0x80 == 0 {
            *rest = &rest[index + 1..];
            return Ok(value);
        }
    }
    Err(match rest.len() {
        0..10 => ProtobufError::Truncated,
        _ => ProtobufError::TooLarge,
    })
}

/// Decodes the sign of an `sint` field: 0, -1, 1, -2, 2 …
fn unzigzag(value: u64) -> i64 {
    (value >> 1) as i64 ^ -((value & 1) as i64)
}

impl<'a> ProtobufField<'a> {
    /// The content of a text or a nested message.
    pub fn bytes(&self) -> Result<&'a [u8], ProtobufError> {
        match self.content {
            Content::Bytes(bytes) => Ok(bytes),
            Content::Varint(_) | Content::Fixed => Err(ProtobufError::OtherType(self.number)),
        }
    }

    /// The value of an `int32`, `int64`, `uint32`, `uint64` or `enum`; negative values are in two's complement.
    pub fn int(&self) -> Result<i64, ProtobufError> {
        match self.content {
            Content::Varint(mut encoded) => Ok(take_varint(&mut encoded)? as i64),
            Content::Bytes(_) | Content::Fixed => Err(ProtobufError::OtherType(self.number)),
        }
    }

    /// The value of an `sint32` or `sint64`.
    pub fn sint(&self) -> Result<i64, ProtobufError> {
        Ok(unzigzag(self.int()? as u64))
    }
}

/// The numbers of a `repeated` field, which may be packed into one field or be in a field each.
#[derive(Clone, Debug, Default)]
pub struct ProtobufNumbers<'a>(Vec<&'a [u8]>);

impl<'a> ProtobufNumbers<'a> {
    /// Appends the numbers of a field.
    pub fn extend(&mut self, field: &ProtobufField<'a>) -> Result<(), ProtobufError> {
        match field.content {
            Content::Varint(encoded) | Content::Bytes(encoded) => self.0.push(encoded),
            Content::Fixed => return Err(ProtobufError::OtherType(field.number)),
        }
        Ok(())
    }

    /// The numbers without decoding of signs.
    pub fn ints(&self) -> impl Iterator<Item = Result<u64, ProtobufError>> {
        self.0.iter().flat_map(|encoded| {
            let mut rest = *encoded;
            std::iter::from_fn(move || {
                if rest.is_empty() {
                    return None;
                }
                let value = take_varint(&mut rest);
                if value.is_err() {
                    rest = &[];
                }
                Some(value)
            })
        })
    }

    /// The running sums of differences encoded as `sint`: OSM's delta coding.
    pub fn sums(&self) -> impl Iterator<Item = Result<i64, ProtobufError>> {
        let mut sum = 0_i64;
        self.ints().map(move |difference| {
            sum = sum
                .checked_add(unzigzag(difference?))
                .ok_or(ProtobufError::TooLarge)?;
            Ok(sum)
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_reads_the_examples_of_the_specification() {
        // field 1 = 150; field 2 = "testing"; field 6 = [3, 270, 86942], packed
        let message = b"\x08\x96\x01\x12\x07testing\x32\x06\x03\x8e\x02\x9e\xa7\x05";
        let all: Vec<ProtobufField<'_>> = fields(message).collect::<Result<_, _>>().unwrap();
        assert_eq!(
            all.iter().map(|it| it.number).collect::<Vec<_>>(),
            [1, 2, 6]
        );
        assert_eq!(all[0].int(), Ok(150));
        assert_eq!(all[1].bytes(), Ok(&b"testing"[..]));
        assert_eq!(all[0].bytes(), Err(ProtobufError::OtherType(1)));
        assert_eq!(all[1].int(), Err(ProtobufError::OtherType(2)));
        let mut numbers = ProtobufNumbers::default();
        numbers.extend(&all[2]).unwrap();
        // the same field once more, not packed
        numbers.extend(&all[0]).unwrap();
        let ints: Result<Vec<u64>, _> = numbers.ints().collect();
        assert_eq!(ints, Ok(vec![3, 270, 86942, 150]));
    }

    #[test]
    fn signs_alternate() {
        let signed = [0, 1, 2, 3, 0xffff_fffe, 0xffff_ffff, u64::MAX - 1, u64::MAX];
        let expected = [0, -1, 1, -2, 0x7fff_ffff, -0x8000_0000, i64::MAX, i64::MIN];
        assert_eq!(signed.map(unzigzag), expected);
    }

    #[test]
    fn it_skips_what_has_a_fixed_length() {
        let message = b"\x09\0\0\0\0\0\0\0\0\x15\0\0\0\0\x18\x05";
        let last = fields(message).last().unwrap().unwrap();
        assert_eq!((last.number, last.int()), (3, Ok(5)));
    }

    #[test]
    fn it_refuses_what_is_cut_off_or_too_large() {
        let error = |message: &[u8]| fields(message).find_map(Result::err);
        assert_eq!(error(b"\x08"), Some(ProtobufError::Truncated));
        assert_eq!(error(b"\x08\x96"), Some(ProtobufError::Truncated));
        assert_eq!(error(b"\x12\x07test"), Some(ProtobufError::Truncated));
        assert_eq!(error(b"\x09\0\0"), Some(ProtobufError::Truncated));
        assert_eq!(error(b"\x0b"), Some(ProtobufError::WireType(3)));
        let lengthy = b"\x08\xff\xff\xff\xff\xff\xff\xff\xff\xff\x7f";
        assert_eq!(error(lengthy), Some(ProtobufError::TooLarge));
        assert_eq!(error(&[0x80; 11]), Some(ProtobufError::TooLarge));
        // twice the largest difference
        let mut numbers = ProtobufNumbers::default();
        let largest = b"\x0a\x14\xfe\xff\xff\xff\xff\xff\xff\xff\xff\x01\xfe\xff\xff\xff\xff\xff\xff\xff\xff\x01";
        let field = fields(largest).next().unwrap().unwrap();
        numbers.extend(&field).unwrap();
        let sums: Vec<_> = numbers.sums().collect();
        assert_eq!(sums, [Ok(i64::MAX), Err(ProtobufError::TooLarge)]);
    }
}
