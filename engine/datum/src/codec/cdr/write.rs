//! Writes a datum according to a schema.

use std::borrow::Cow;

use super::{DEPTH, Format, LITTLE, deeper, shapeless};
use crate::codec::special_float;
use crate::error::{DatumError, DatumProblem};
use crate::schema::{OutlineKey, Schema, Shape};
use crate::value::{Datum, FieldName};

/// Encodes a datum, with the encapsulation header.
pub(crate) fn write_whole(datum: &Datum, schema: &Schema) -> Result<Vec<u8>, DatumError> {
    let mut writer = SchemaWriter {
        bytes: LITTLE.to_vec(),
        format: Format::Cdr,
    };
    writer.one(datum, schema, DEPTH)?;
    Ok(writer.bytes)
}

/// Encodes a datum as a message of ROS 1, after bytes that precede it.
pub(crate) fn write_ros1(
    datum: &Datum,
    schema: &Schema,
    before: Vec<u8>,
) -> Result<Vec<u8>, DatumError> {
    let mut writer = SchemaWriter {
        bytes: before,
        format: Format::Ros1,
    };
    writer.one(datum, schema, DEPTH)?;
    Ok(writer.bytes)
}

struct SchemaWriter {
    /// The bytes written so far, including the header of CDR.
    bytes: Vec<u8>,
    format: Format,
}

impl SchemaWriter {
    fn one(&mut self, datum: &Datum, schema: &Schema, depth: usize) -> Result<(), DatumError> {
        let depth = deeper(depth)?;
        match &schema.shape {
            Shape::Any => return Err(shapeless(self.format, schema)),
            Shape::Bool => {
                let value = datum.as_bool().ok_or_else(|| misfit(datum, schema))?;
                self.write_aligned([u8::from(value)]);
            }
            Shape::I8 => self.write_aligned(integer::<i8>(datum, schema)?.to_le_bytes()),
            Shape::I16 => self.write_aligned(integer::<i16>(datum, schema)?.to_le_bytes()),
            Shape::I32 => self.write_aligned(integer::<i32>(datum, schema)?.to_le_bytes()),
            Shape::I64 => self.write_aligned(integer::<i64>(datum, schema)?.to_le_bytes()),
            Shape::U8 => self.write_aligned(integer::<u8>(datum, schema)?.to_le_bytes()),
            Shape::U16 => self.write_aligned(integer::<u16>(datum, schema)?.to_le_bytes()),
            Shape::U32 => self.write_aligned(integer::<u32>(datum, schema)?.to_le_bytes()),
            Shape::U64 => self.write_aligned(integer::<u64>(datum, schema)?.to_le_bytes()),
            Shape::F32 => self.write_aligned((float(datum, schema)? as f32).to_le_bytes()),
            Shape::F64 => self.write_aligned(float(datum, schema)?.to_le_bytes()),
            Shape::Text => self.text(datum.as_text().ok_or_else(|| misfit(datum, schema))?)?,
            Shape::Option(element) => {
                if *datum == Datum::Null {
                    self.count(0)?;
                } else {
                    self.count(1)?;
                    self.one(datum, element, depth)?;
                }
            }
            Shape::List(element) => {
                let count = elements(datum).ok_or_else(|| misfit(datum, schema))?;
                self.count(count)?;
                self.many(datum, element, count, depth)?;
            }
            Shape::Array(_, 0) => return Err(shapeless(self.format, schema)),
            Shape::Array(element, count) => {
                if elements(datum) != Some(*count) {
                    return Err(misfit(datum, schema));
                }
                self.many(datum, element, *count, depth)?;
            }
            Shape::Record(fields) => {
                let Datum::Record(entries) = datum else {
                    return Err(misfit(datum, schema));
                };
                self.record(entries, fields, depth)?;
            }
        }
        Ok(())
    }

    /// Writes the bytes of a number, aligned to its size.
    fn write_aligned<const N: usize>(&mut self, bytes: [u8; N]) {
        self.align(N);
        self.bytes.extend_from_slice(&bytes);
    }

    fn align(&mut self, size: usize) {
        if self.format == Format::Ros1 {
            return;
        }
        let body = self.bytes.len() - LITTLE.len();
        self.bytes
            .resize(LITTLE.len() + body.next_multiple_of(size), 0);
    }

    fn count(&mut self, count: usize) -> Result<(), DatumError> {
        let count = u32::try_from(count).map_err(|_| {
            DatumError::new(DatumProblem::Mismatch(format!(
                "{count} elements are more than 32 bits can count"
            )))
        })?;
        self.write_aligned(count.to_le_bytes());
        Ok(())
    }

    /// Writes a string; in CDR, its length includes the terminating zero.
    fn text(&mut self, text: &str) -> Result<(), DatumError> {
        if self.format == Format::Ros1 {
            self.count(text.len())?;
            self.bytes.extend_from_slice(text.as_bytes());
            return Ok(());
        }
        self.count(text.len() + 1)?;
        self.bytes.extend_from_slice(text.as_bytes());
        self.bytes.push(0);
        Ok(())
    }

    /// Writes the elements of a sequence or array. Packed numbers of the right type are written in one block.
    fn many(
        &mut self,
        run: &Datum,
        element: &Schema,
        count: usize,
        depth: usize,
    ) -> Result<(), DatumError> {
        if let (Datum::Bytes(bytes), Shape::U8) = (run, &element.shape) {
            self.bytes.extend_from_slice(bytes);
            return Ok(());
        }
        if let Datum::Numbers(numbers) = run
            && element.shape == numbers.shape()
        {
            // an empty sequence adds no alignment
            if !numbers.is_empty() {
                self.align(numbers.size());
            }
            numbers.append_to(&mut self.bytes);
            return Ok(());
        }
        (0..count).try_for_each(|index| match run.element(index) {
            Some(one) => self
                .one(&one, element, depth)
                .map_err(|error| error.within(index)),
            None => Err(misfit(run, element)),
        })
    }

    fn record(
        &mut self,
        entries: &[(FieldName, Datum)],
        fields: &[OutlineKey],
        depth: usize,
    ) -> Result<(), DatumError> {
        if fields.is_empty() && self.format == Format::Cdr {
            // ROS 2 gives a message without fields one byte, because IDL has no empty structures
            self.write_aligned([0]);
        }
        // usually the entries are in the schema's order
        let mut are_in_order = entries.len() == fields.len();
        for (index, field) in fields.iter().enumerate() {
            let named = |entry: &&(FieldName, Datum)| entry.0 == field.name;
            let entry = entries.get(index).filter(named);
            are_in_order &= entry.is_some();
            let entry = entry.or_else(|| entries.iter().find(named));
            let datum = match entry {
                Some((_, datum)) => Cow::Borrowed(datum),
                None => Cow::Owned(field.initial()),
            };
            self.one(&datum, &field.schema, depth)
                .map_err(|error| error.within(&field.name))?;
        }
        if are_in_order {
            return Ok(());
        }
        let unknown =
            |(name, _): &&(FieldName, Datum)| fields.iter().all(|field| field.name != *name);
        if let Some((name, _)) = entries.iter().find(unknown) {
            let unknown = format!("unknown field `{name}`");
            return Err(DatumError::new(DatumProblem::Mismatch(unknown)));
        }
        Ok(())
    }
}

/// The number of elements of a list, of packed numbers or of bytes; `None` for anything else.
fn elements(datum: &Datum) -> Option<usize> {
    match datum {
        Datum::List(_) | Datum::Numbers(_) | Datum::Bytes(_) => datum.count(),
        Datum::Null
        | Datum::Bool(_)
        | Datum::Int(_)
        | Datum::Float(_)
        | Datum::Text(_)
        | Datum::Record(_) => None,
    }
}

fn integer<N: TryFrom<i64>>(datum: &Datum, schema: &Schema) -> Result<N, DatumError> {
    let value = datum.as_int().ok_or_else(|| misfit(datum, schema))?;
    N::try_from(value).map_err(|_| {
        let reason = format!("{value} does not fit `{schema}`");
        DatumError::new(DatumProblem::Mismatch(reason))
    })
}

/// A float from a number, or from a text such as `"NaN"` that stands for one.
fn float(datum: &Datum, schema: &Schema) -> Result<f64, DatumError> {
    let special = || datum.as_text().and_then(special_float);
    datum
        .as_float()
        .or_else(special)
        .ok_or_else(|| misfit(datum, schema))
}

fn misfit(datum: &Datum, schema: &Schema) -> DatumError {
    let found = match elements(datum) {
        Some(count) => format!("{} of {count}", datum.kind()),
        None => datum.kind().to_owned(),
    };
    DatumError::new(DatumProblem::Mismatch(format!(
        "expected `{schema}`, found {found}"
    )))
}
