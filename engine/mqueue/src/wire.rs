//! Encodes and decodes messages.

use asmotion_datum::{Datum, DatumError, DatumProblem, Numbers, Schema, Shape};

use crate::layout::{QueueLayout, min_size};

impl QueueLayout {
    /// Appends an encoded message to `out`. Omitted fields are zero, false or empty.
    ///
    /// # Errors
    /// The first difference from the layout's type, with its place.
    pub fn encode(&self, datum: &Datum, out: &mut Vec<u8>) -> Result<(), DatumError> {
        encode_value(self.schema(), Some(datum), out)
    }

    /// Appends a message of zeros.
    pub(crate) fn encode_zeros(&self, out: &mut Vec<u8>) -> Result<(), DatumError> {
        encode_value(self.schema(), None, out)
    }

    /// Decodes a message, which must occupy all bytes.
    ///
    /// # Errors
    /// An error if there are too many or too few bytes, or if a value is invalid, with its place.
    pub fn decode(&self, bytes: &[u8]) -> Result<Datum, DatumError> {
        let mut remaining = bytes;
        let datum = decode_value(self.schema(), &mut remaining)?;
        match remaining.len() {
            0 => Ok(datum),
            left => Err(malformed(format!(
                "{} has {} bytes, not {}",
                self.schema(),
                bytes.len() - left,
                bytes.len()
            ))),
        }
    }
}

fn malformed(reason: String) -> DatumError {
    let codec = "message queue data";
    DatumError::new(DatumProblem::Malformed { codec, reason })
}

fn mismatch(schema: &Schema, datum: &Datum) -> DatumError {
    let problem = format!("expected {schema}, found {}", datum.kind());
    DatumError::new(DatumProblem::Mismatch(problem))
}

fn encode_value(
    schema: &Schema,
    datum: Option<&Datum>,
    out: &mut Vec<u8>,
) -> Result<(), DatumError> {
    macro_rules! whole {
        ($type:ty) => {{
            let value = match datum {
                None => 0,
                Some(datum) => datum.as_int().ok_or_else(|| mismatch(schema, datum))?,
            };
            let value = <$type>::try_from(value).map_err(|_| {
                DatumError::new(DatumProblem::Mismatch(format!(
                    "expected {schema}, found {value}"
                )))
            })?;
            out.extend(value.to_ne_bytes());
        }};
    }
    let float = || match datum {
        None => Ok(0.0),
        Some(datum) => datum.as_float().ok_or_else(|| mismatch(schema, datum)),
    };
    match &schema.shape {
        // cannot occur: the layout has refused these types
        Shape::Any | Shape::Text | Shape::Option(_) => {
            return Err(mismatch(schema, datum.unwrap_or(&Datum::Null)));
        }
        Shape::Bool => {
            let value = match datum {
                None => false,
                Some(datum) => datum.as_bool().ok_or_else(|| mismatch(schema, datum))?,
            };
            out.push(u8::from(value));
        }
        Shape::I8 => whole!(i8),
        Shape::I16 => whole!(i16),
        Shape::I32 => whole!(i32),
        Shape::I64 => whole!(i64),
        Shape::U8 => whole!(u8),
        Shape::U16 => whole!(u16),
        Shape::U32 => whole!(u32),
        Shape::U64 => whole!(u64),
        Shape::F32 => out.extend((float()? as f32).to_ne_bytes()),
        Shape::F64 => out.extend(float()?.to_ne_bytes()),
        Shape::List(element) => {
            let Some(datum) = datum else {
                out.extend(0_u64.to_ne_bytes());
                return Ok(());
            };
            let count = elements(datum).ok_or_else(|| mismatch(schema, datum))?;
            out.extend((count as u64).to_ne_bytes());
            encode_elements(element, datum, count, out)?;
        }
        Shape::Array(element, count) => match datum {
            None => (0..*count).try_for_each(|_| encode_value(element, None, out))?,
            Some(datum) => match elements(datum) {
                None => return Err(mismatch(schema, datum)),
                Some(given) if given == *count => encode_elements(element, datum, given, out)?,
                Some(given) => {
                    let problem = format!("expected {schema}, found {given} elements");
                    return Err(DatumError::new(DatumProblem::Mismatch(problem)));
                }
            },
        },
        Shape::Record(fields) => {
            let entries = match datum {
                None => &[],
                Some(Datum::Record(entries)) => entries.as_slice(),
                Some(other) => return Err(mismatch(schema, other)),
            };
            for field in fields {
                let entry = entries.iter().find(|(name, _)| *name == field.name);
                encode_value(&field.schema, entry.map(|(_, value)| value), out)
                    .map_err(|error| error.within(&field.name))?;
            }
        }
    }
    Ok(())
}

/// Number of elements of a list, of packed numbers or of bytes; `None` for anything else.
fn elements(datum: &Datum) -> Option<usize> {
    match datum {
        Datum::Record(_) => None,
        Datum::Null
        | Datum::Bool(_)
        | Datum::Int(_)
        | Datum::Float(_)
        | Datum::Text(_)
        | Datum::Bytes(_)
        | Datum::Numbers(_)
        | Datum::List(_) => datum.count(),
    }
}

fn encode_elements(
    element: &Schema,
    datum: &Datum,
    count: usize,
    out: &mut Vec<u8>,
) -> Result<(), DatumError> {
    match (&element.shape, datum) {
        (Shape::F64, Datum::Numbers(Numbers::F64(all))) => {
            out.extend(all.iter().flat_map(|number| number.to_ne_bytes()));
            return Ok(());
        }
        (Shape::U8, Datum::Bytes(bytes)) => {
            out.extend_from_slice(bytes);
            return Ok(());
        }
        _ => {}
    }
    for index in 0..count {
        encode_value(element, datum.element(index).as_deref(), out)
            .map_err(|error| error.within(index))?;
    }
    Ok(())
}

/// Removes the first `N` bytes.
fn take_bytes<const N: usize>(schema: &Schema, rest: &mut &[u8]) -> Result<[u8; N], DatumError> {
    match rest.split_first_chunk() {
        Some((chunk, left)) => {
            *rest = left;
            Ok(*chunk)
        }
        None => Err(malformed(format!(
            "{schema} has {N} bytes, but {} are left",
            rest.len()
        ))),
    }
}

fn decode_value(schema: &Schema, rest: &mut &[u8]) -> Result<Datum, DatumError> {
    macro_rules! whole {
        ($type:ty) => {{
            let value = <$type>::from_ne_bytes(take_bytes(schema, rest)?);
            i64::try_from(value)
                .map(Datum::Int)
                .map_err(|_| DatumError::new(DatumProblem::IntegerTooBig(value.to_string())))
        }};
    }
    match &schema.shape {
        // cannot occur: the layout has refused these types
        Shape::Any | Shape::Text | Shape::Option(_) => Err(mismatch(schema, &Datum::Null)),
        Shape::Bool => match take_bytes::<1>(schema, rest)? {
            [0] => Ok(Datum::Bool(false)),
            [1] => Ok(Datum::Bool(true)),
            [other] => Err(malformed(format!(
                "expected 0 or 1 for a Boolean, found {other}"
            ))),
        },
        Shape::I8 => whole!(i8),
        Shape::I16 => whole!(i16),
        Shape::I32 => whole!(i32),
        Shape::I64 => whole!(i64),
        Shape::U8 => whole!(u8),
        Shape::U16 => whole!(u16),
        Shape::U32 => whole!(u32),
        Shape::U64 => whole!(u64),
        Shape::F32 => Ok(Datum::Float(
            f32::from_ne_bytes(take_bytes(schema, rest)?).into(),
        )),
        Shape::F64 => Ok(Datum::Float(f64::from_ne_bytes(take_bytes(schema, rest)?))),
        Shape::List(element) => {
            let count = u64::from_ne_bytes(take_bytes(schema, rest)?);
            decode_elements(element, usize::try_from(count).unwrap_or(usize::MAX), rest)
        }
        Shape::Array(element, count) => decode_elements(element, *count, rest),
        Shape::Record(fields) => {
            let entries = fields.iter().map(|field| {
                let value =
                    decode_value(&field.schema, rest).map_err(|error| error.within(&field.name))?;
                Ok((field.name.clone(), value))
            });
            entries.collect::<Result<_, _>>().map(Datum::Record)
        }
    }
}

/// Reads `count` elements. Fails before allocation if there cannot be enough bytes.
fn decode_elements(element: &Schema, count: usize, rest: &mut &[u8]) -> Result<Datum, DatumError> {
    if min_size(&element.shape).saturating_mul(count) > rest.len() {
        return Err(malformed(format!(
            "expected {count} elements of {element}, but {} bytes are left",
            rest.len()
        )));
    }
    if element.shape == Shape::F64 {
        let (numbers, left) = rest.split_at(count * size_of::<f64>());
        *rest = left;
        let (numbers, _) = numbers.as_chunks();
        let numbers = numbers.iter().map(|number| f64::from_ne_bytes(*number));
        Ok(Datum::Numbers(Numbers::F64(numbers.collect())))
    } else if element.shape == Shape::U8 {
        let (bytes, left) = rest.split_at(count);
        *rest = left;
        Ok(Datum::Bytes(bytes.into()))
    } else {
        let all = (0..count)
            .map(|index| decode_value(element, rest).map_err(|error| error.within(index)));
        all.collect::<Result<_, _>>().map(Datum::List)
    }
}

#[cfg(test)]
mod tests {
    use asmotion_datum::Message;
    use proptest::prelude::*;

    use super::*;

    asmotion_datum::message! {
        /// A mixture of types that have a layout.
        #[derive(Copy)]
        pub struct Inner = "test/Inner" {
            pub flag: bool,
            pub small: i8,
            pub big: u64,
        }

        pub struct Outer = "test/Outer" {
            pub ready: bool,
            pub level: f32,
            pub position: Vec<f64>,
            pub errors: [u16; 3],
            pub bytes: Vec<u8>,
            pub inner: Vec<Inner>,
            pub limits: Vec<Vec<i32>>,
        }

        pub struct Named = "test/Named" {
            pub inner: [Spoken; 2],
        }

        pub struct Spoken = "test/Spoken" {
            pub name: String,
        }
    }

    fn outer() -> Outer {
        Outer {
            ready: true,
            level: 0.5,
            position: vec![1.0, -2.0],
            errors: [1, 2, 3],
            bytes: vec![7, 8],
            inner: vec![Inner {
                flag: true,
                small: -1,
                big: 9,
            }],
            limits: vec![vec![], vec![5]],
        }
    }

    fn encode(datum: &Datum) -> Result<Vec<u8>, DatumError> {
        let mut out = Vec::new();
        QueueLayout::of(Outer::schema())
            .unwrap()
            .encode(datum, &mut out)?;
        Ok(out)
    }

    #[test]
    fn members_stand_one_after_the_other_without_padding() {
        let mut expected = vec![1];
        expected.extend(0.5_f32.to_ne_bytes());
        expected.extend(2_u64.to_ne_bytes());
        expected.extend(1.0_f64.to_ne_bytes());
        expected.extend((-2.0_f64).to_ne_bytes());
        expected.extend([1_u16, 2, 3].iter().flat_map(|n| n.to_ne_bytes()));
        expected.extend(2_u64.to_ne_bytes());
        expected.extend([7, 8]);
        expected.extend(1_u64.to_ne_bytes());
        expected.extend([1, 255]);
        expected.extend(9_u64.to_ne_bytes());
        expected.extend(2_u64.to_ne_bytes());
        expected.extend(0_u64.to_ne_bytes());
        expected.extend(1_u64.to_ne_bytes());
        expected.extend(5_i32.to_ne_bytes());
        assert_eq!(encode(&Datum::of(&outer()).unwrap()).unwrap(), expected);
    }

    #[test]
    fn what_is_left_out_is_zero() {
        let nothing = encode(&Datum::Record(Vec::new())).unwrap();
        assert_eq!(
            nothing,
            encode(&Datum::of(&Outer::default()).unwrap()).unwrap()
        );
        assert!(nothing.iter().all(|byte| *byte == 0));
        assert_eq!(nothing.len(), 1 + 4 + 8 + 6 + 8 + 8 + 8);
    }

    #[test]
    fn what_does_not_fit_is_named_with_its_place() {
        let wrong = Datum::record([("errors", Datum::List(vec![Datum::Int(70_000); 3]))]);
        let problem = encode(&wrong).unwrap_err().to_string();
        assert_eq!(problem, "`errors.0`: expected uint16, found 70000");
        let short = Datum::record([("errors", Datum::List(vec![Datum::Int(1)]))]);
        let problem = encode(&short).unwrap_err().to_string();
        assert_eq!(problem, "`errors`: expected uint16[3], found 1 elements");
        let text = Datum::record([("position", Datum::text("far"))]);
        let problem = encode(&text).unwrap_err().to_string();
        assert_eq!(problem, "`position`: expected float64[], found a string");
    }

    #[test]
    fn text_has_no_form() {
        let refused = QueueLayout::of(Named::schema()).unwrap_err().to_string();
        assert!(
            refused.starts_with("`inner.name`: string has no encoding"),
            "{refused}"
        );
    }

    #[test]
    fn a_count_beyond_the_message_takes_no_memory() {
        let layout = QueueLayout::of(&Schema::many(Schema::plain(Shape::F64), None)).unwrap();
        let problem = layout.decode(&u64::MAX.to_ne_bytes()).unwrap_err();
        assert!(
            problem.to_string().contains("0 bytes are left"),
            "{problem}"
        );
        let problem = layout.decode(&[0; 9]).unwrap_err();
        assert!(
            problem.to_string().contains("has 8 bytes, not 9"),
            "{problem}"
        );
    }

    proptest! {
        #[test]
        fn what_was_written_is_read(
            ready: bool, level: f32, position: Vec<f64>, errors: [u16; 3], bytes: Vec<u8>,
            inner in proptest::collection::vec((any::<bool>(), any::<i8>(), 0..=i64::MAX as u64), 0..4),
            limits: Vec<Vec<i32>>,
        ) {
            prop_assume!(!level.is_nan() && !position.iter().any(|it| it.is_nan()));
            let inner = inner.into_iter().map(|(flag, small, big)| Inner { flag, small, big }).collect();
            let written = Outer { ready, level, position, errors, bytes, inner, limits };
            let bytes = encode(&Datum::of(&written).unwrap()).unwrap();
            let read = QueueLayout::of(Outer::schema()).unwrap().decode(&bytes).unwrap();
            prop_assert_eq!(read.to::<Outer>().unwrap(), written);
        }

        #[test]
        fn no_bytes_are_too_strange(bytes: Vec<u8>) {
            let _ = QueueLayout::of(Outer::schema()).unwrap().decode(&bytes);
        }
    }
}
