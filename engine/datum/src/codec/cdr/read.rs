//! Reads a datum according to a schema. An announced length is trusted only as far as there are bytes.

use super::{BIG, DEPTH, Format, LITTLE, deeper, malformed, shapeless};
use crate::error::{DatumError, DatumProblem};
use crate::numbers::Numbers;
use crate::schema::{OutlineKey, Schema, Shape};
use crate::value::Datum;

/// Longest padding at the end: some writers pad messages to a multiple of four bytes.
const PADDING: usize = 3;
/// Largest number of elements in a sequence whose elements have no bytes, which no length of the message bounds.
const MOST_WITHOUT_BYTES: usize = 1 << 16;

/// Decodes one datum; nothing but padding may follow.
pub(crate) fn read_whole(bytes: &[u8], schema: &Schema) -> Result<Datum, DatumError> {
    let Some((header, body)) = bytes.split_at_checked(LITTLE.len()) else {
        return Err(malformed(Format::Cdr, "unexpected end"));
    };
    // the last two header bytes are options, without meaning for plain CDR
    let big_first = match [header[0], header[1]] {
        kind if kind == LITTLE[..2] => false,
        kind if kind == BIG[..2] => true,
        kind => {
            return Err(malformed(
                Format::Cdr,
                format_args!("representation {kind:02x?} is not plain CDR"),
            ));
        }
    };
    let mut reader = SchemaReader {
        body,
        at: 0,
        big_first,
        format: Format::Cdr,
    };
    let datum = reader.one(schema, DEPTH)?;
    if reader.remaining() > PADDING {
        return Err(malformed(Format::Cdr, "trailing bytes"));
    }
    Ok(datum)
}

/// Decodes one datum from a message of ROS 1; nothing may follow.
pub(crate) fn read_ros1(bytes: &[u8], schema: &Schema) -> Result<Datum, DatumError> {
    let mut reader = SchemaReader {
        body: bytes,
        at: 0,
        big_first: false,
        format: Format::Ros1,
    };
    let datum = reader.one(schema, DEPTH)?;
    match reader.remaining() {
        0 => Ok(datum),
        rest => Err(reader.malformed(format_args!("{rest} bytes follow the message"))),
    }
}

struct SchemaReader<'b> {
    body: &'b [u8],
    at: usize,
    big_first: bool,
    format: Format,
}

impl<'b> SchemaReader<'b> {
    fn malformed(&self, reason: impl ToString) -> DatumError {
        malformed(self.format, reason)
    }

    fn one(&mut self, schema: &Schema, depth: usize) -> Result<Datum, DatumError> {
        let depth = deeper(depth)?;
        Ok(match &schema.shape {
            Shape::Any | Shape::Array(_, 0) => return Err(shapeless(self.format, schema)),
            Shape::Bool => Datum::Bool(match self.number::<1>()? {
                [0] => false,
                [1] => true,
                [other] => return Err(self.malformed(format_args!("{other} is not a Boolean"))),
            }),
            Shape::I8 => Datum::Int(i8::from_le_bytes(self.number()?).into()),
            Shape::I16 => Datum::Int(i16::from_le_bytes(self.number()?).into()),
            Shape::I32 => Datum::Int(i32::from_le_bytes(self.number()?).into()),
            Shape::I64 => Datum::Int(i64::from_le_bytes(self.number()?)),
            Shape::U8 => Datum::Int(u8::from_le_bytes(self.number()?).into()),
            Shape::U16 => Datum::Int(u16::from_le_bytes(self.number()?).into()),
            Shape::U32 => Datum::Int(u32::from_le_bytes(self.number()?).into()),
            Shape::U64 => {
                let value = u64::from_le_bytes(self.number()?);
                let too_big = |_| DatumError::new(DatumProblem::IntegerTooBig(value.to_string()));
                Datum::Int(i64::try_from(value).map_err(too_big)?)
            }
            Shape::F32 => Datum::Float(f32::from_le_bytes(self.number()?).into()),
            Shape::F64 => Datum::Float(f64::from_le_bytes(self.number()?)),
            Shape::Text => Datum::Text(self.text()?),
            Shape::Option(element) => match self.count()? {
                0 => Datum::Null,
                1 => self.one(element, depth)?,
                more => {
                    return Err(
                        self.malformed(format_args!("{more} elements in an optional value"))
                    );
                }
            },
            Shape::List(element) => {
                let count = self.count()?;
                self.many(element, count, depth)?
            }
            Shape::Array(element, count) => self.many(element, *count, depth)?,
            Shape::Record(fields) => self.record(fields, depth)?,
        })
    }

    fn remaining(&self) -> usize {
        self.body.len().saturating_sub(self.at)
    }

    fn align(&mut self, size: usize) {
        if self.format == Format::Ros1 {
            return;
        }
        self.at = self.at.next_multiple_of(size);
    }

    fn take(&mut self, count: usize) -> Result<&'b [u8], DatumError> {
        let end = self.at.checked_add(count);
        let bytes = end.and_then(|end| self.body.get(self.at..end));
        let taken = bytes.ok_or_else(|| self.malformed("unexpected end"))?;
        self.at += count;
        Ok(taken)
    }

    /// Reads an aligned number and returns its bytes in little-endian order.
    fn number<const N: usize>(&mut self) -> Result<[u8; N], DatumError> {
        self.align(N);
        let mut bytes = [0; N];
        bytes.copy_from_slice(self.take(N)?);
        if self.big_first {
            bytes.reverse();
        }
        Ok(bytes)
    }

    fn count(&mut self) -> Result<usize, DatumError> {
        let count = u32::from_le_bytes(self.number()?);
        usize::try_from(count).map_err(|error| self.malformed(error))
    }

    /// Reads a string. In CDR its length includes the terminating zero. Some writers encode an empty string with length
    /// 0 and no terminator.
    fn text(&mut self) -> Result<String, DatumError> {
        let length = self.count()?;
        match self.take(length)? {
            text if self.format == Format::Ros1 => {
                String::from_utf8(text.to_vec()).map_err(|error| self.malformed(error))
            }
            [] => Ok(String::new()),
            [text @ .., 0] => {
                String::from_utf8(text.to_vec()).map_err(|error| self.malformed(error))
            }
            _ => Err(self.malformed("string without terminating zero")),
        }
    }

    /// Reads the elements of a sequence or array. Primitive numbers are read in one block.
    fn many(&mut self, element: &Schema, count: usize, depth: usize) -> Result<Datum, DatumError> {
        if element.shape == Shape::U8 {
            return Ok(Datum::Bytes(self.take(count)?.into()));
        }
        if let Some(size) = Numbers::size_of(&element.shape) {
            return self.numbers(&element.shape, size, count);
        }
        let most = if self.format == Format::Ros1 && has_no_bytes(element) {
            MOST_WITHOUT_BYTES
        } else {
            self.remaining()
        };
        if count > most {
            return Err(self.malformed("unexpected end"));
        }
        let mut elements = Vec::new();
        for index in 0..count {
            let one = self.one(element, depth);
            elements.push(one.map_err(|error| error.within(index))?);
        }
        Ok(Datum::List(elements))
    }

    fn numbers(&mut self, shape: &Shape, size: usize, count: usize) -> Result<Datum, DatumError> {
        if count > 0 {
            self.align(size);
        }
        let bytes = self.take(count.saturating_mul(size))?;
        let numbers = if self.big_first {
            let mut turned = bytes.to_vec();
            turned.chunks_exact_mut(size).for_each(<[u8]>::reverse);
            Numbers::from_shape(shape, &turned)
        } else {
            Numbers::from_shape(shape, bytes)
        };
        numbers
            .map(Datum::Numbers)
            .ok_or_else(|| self.malformed("numbers of an unknown type"))
    }

    fn record(&mut self, fields: &[OutlineKey], depth: usize) -> Result<Datum, DatumError> {
        if fields.is_empty() && self.format == Format::Cdr {
            self.take(1)?;
        }
        let mut entries = Vec::with_capacity(fields.len());
        for field in fields {
            let value = self.one(&field.schema, depth);
            let value = value.map_err(|error| error.within(&field.name))?;
            entries.push((field.name.clone(), value));
        }
        Ok(Datum::Record(entries))
    }
}

/// Returns `true` if data of the schema have no bytes in ROS 1: messages without fields.
fn has_no_bytes(schema: &Schema) -> bool {
    match &schema.shape {
        Shape::Record(fields) => fields.iter().all(|field| has_no_bytes(&field.schema)),
        Shape::Array(element, _) => has_no_bytes(element),
        Shape::Any
        | Shape::Bool
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
        | Shape::Text
        | Shape::Option(_)
        | Shape::List(_) => false,
    }
}
