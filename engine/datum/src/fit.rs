//! Checks data against a schema before it is converted to a type.

use crate::codec::special_float;
use crate::error::{DatumError, DatumProblem, repeated_name};
use crate::schema::{OutlineKey, Schema, Shape};
use crate::value::{Datum, FieldName};

impl Schema {
    /// Checks that a datum fits the schema. As in decoding, fields may be omitted and in any order; an unknown field is
    /// an error.
    ///
    /// # Errors
    /// The first mismatch.
    pub fn accepts(&self, datum: &Datum) -> Result<(), DatumError> {
        match &self.shape {
            Shape::Any => Ok(()),
            Shape::Bool => self.check(datum.as_bool().is_some(), datum),
            Shape::I8 => self.check_integer(i8::MIN, i8::MAX, datum),
            Shape::I16 => self.check_integer(i16::MIN, i16::MAX, datum),
            Shape::I32 => self.check_integer(i32::MIN, i32::MAX, datum),
            Shape::I64 => self.check_integer(i64::MIN, i64::MAX, datum),
            Shape::U8 => self.check_integer(u8::MIN, u8::MAX, datum),
            Shape::U16 => self.check_integer(u16::MIN, u16::MAX, datum),
            Shape::U32 => self.check_integer(u32::MIN, u32::MAX, datum),
            // a datum's integers are signed
            Shape::U64 => self.check_integer(0, i64::MAX, datum),
            Shape::F32 | Shape::F64 => {
                let special = || datum.as_text().and_then(special_float);
                self.check(datum.as_float().or_else(special).is_some(), datum)
            }
            Shape::Text => self.check(datum.as_text().is_some(), datum),
            Shape::Option(_) if datum.is_null() => Ok(()),
            Shape::Option(some) => some.accepts(datum),
            Shape::List(element) => self.check_elements(element, datum).map(drop),
            Shape::Array(element, count) => {
                let found = self.check_elements(element, datum)?;
                let reason = || format!("expected `{self}`, found {found} elements");
                (found == *count)
                    .then_some(())
                    .ok_or_else(|| mismatch(reason()))
            }
            Shape::Record(fields) => {
                let Datum::Record(entries) = datum else {
                    return Err(self.mismatch_with(datum));
                };
                entries
                    .iter()
                    .try_for_each(|(name, value)| self.field(fields, name, value))
            }
        }
    }

    /// Converts a datum to the form that a typed writer would give it: integers where floats are expected become floats,
    /// omitted fields get their initial values, and fields are in the order of the schema.
    ///
    /// ```
    /// use asmotion_datum::{Datum, OutlineKey, Schema, Shape};
    ///
    /// let float = || Schema::plain(Shape::F64);
    /// let fields = vec![OutlineKey::new("x", "m", float()), OutlineKey::new("y", "m", float())];
    /// let point = Schema::record("example/Point", fields);
    /// let complete = point.complete(Datum::record([("y", Datum::Int(2))]))?;
    /// assert_eq!(complete, Datum::record([("x", Datum::Float(0.0)), ("y", Datum::Float(2.0))]));
    /// # Ok::<(), asmotion_datum::DatumError>(())
    /// ```
    ///
    /// # Errors
    /// The first mismatch, as in [`accepts`](Self::accepts), or a field that occurs twice.
    pub fn complete(&self, datum: Datum) -> Result<Datum, DatumError> {
        match (&self.shape, datum) {
            (Shape::F32 | Shape::F64, datum) => {
                let special = || datum.as_text().and_then(special_float);
                let float = datum.as_float().or_else(special);
                float
                    .map(Datum::Float)
                    .ok_or_else(|| self.mismatch_with(&datum))
            }
            (Shape::Option(_), Datum::Null) => Ok(Datum::Null),
            (Shape::Option(some), datum) => some.complete(datum),
            (Shape::List(element) | Shape::Array(element, _), Datum::List(elements)) => {
                let count = elements.len();
                let elements = elements.into_iter().enumerate().map(|(index, datum)| {
                    let complete = element.complete(datum);
                    complete.map_err(|error| error.within(index))
                });
                let elements = elements.collect::<Result<_, _>>()?;
                self.check_count(count)?;
                Ok(Datum::List(elements))
            }
            (Shape::Record(fields), Datum::Record(entries)) => {
                self.complete_fields(fields, entries)
            }
            (_, datum) => self.accepts(&datum).map(|()| datum),
        }
    }

    /// Returns whether no field is omitted, and no float is a text, in a datum that [fits](Self::accepts) the schema.
    pub fn is_complete(&self, datum: &Datum) -> bool {
        match (&self.shape, datum) {
            (Shape::F32 | Shape::F64, Datum::Text(_)) => false,
            (Shape::Option(_), Datum::Null) => true,
            (Shape::Option(some), datum) => some.is_complete(datum),
            (Shape::List(element) | Shape::Array(element, _), Datum::List(elements)) => {
                !element.may_be_incomplete() || elements.iter().all(|it| element.is_complete(it))
            }
            (Shape::Record(fields), Datum::Record(entries)) => fields.iter().all(|field| {
                let mut entries = entries.iter();
                let found = entries.find(|(name, _)| *name == field.name);
                found.is_some_and(|(_, value)| field.schema.is_complete(value))
            }),
            (_, _) => true,
        }
    }

    /// Returns whether data of this shape contain records or floats.
    fn may_be_incomplete(&self) -> bool {
        match &self.shape {
            Shape::Record(_) | Shape::F32 | Shape::F64 => true,
            Shape::Option(inner) | Shape::List(inner) | Shape::Array(inner, _) => {
                inner.may_be_incomplete()
            }
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
            | Shape::Text => false,
        }
    }

    /// Checks the number of elements of an array.
    fn check_count(&self, found: usize) -> Result<(), DatumError> {
        let Shape::Array(_, expected) = self.shape else {
            return Ok(());
        };
        let reason = || format!("expected `{self}`, found {found} elements");
        (found == expected)
            .then_some(())
            .ok_or_else(|| mismatch(reason()))
    }

    fn complete_fields(
        &self,
        fields: &[OutlineKey],
        mut entries: Vec<(FieldName, Datum)>,
    ) -> Result<Datum, DatumError> {
        let mut pairs = entries.iter().zip(fields);
        let are_in_order =
            entries.len() == fields.len() && pairs.all(|((name, _), field)| *name == field.name);
        if are_in_order {
            for ((name, value), field) in entries.iter_mut().zip(fields) {
                let complete = field.schema.complete(std::mem::take(value));
                *value = complete.map_err(|error| error.within(name))?;
            }
            return Ok(Datum::Record(entries));
        }
        let mut found: Vec<Option<Datum>> = vec![None; fields.len()];
        for (name, value) in entries {
            match fields.iter().position(|field| field.name == name) {
                Some(index) if found[index].is_none() => {
                    let complete = fields[index].schema.complete(value);
                    found[index] = Some(complete.map_err(|error| error.within(&name))?);
                }
                Some(_) => return Err(repeated_name(&name)),
                // the error that lists the known fields
                None => self.field(fields, &name, &value)?,
            }
        }
        let complete = fields.iter().zip(found).map(|(field, found)| {
            let value = match found {
                Some(value) => value,
                None => field.schema.complete(field.initial())?,
            };
            Ok((field.name.clone(), value))
        });
        complete
            .collect::<Result<_, DatumError>>()
            .map(Datum::Record)
    }

    fn check_integer<N: Into<i64>>(&self, min: N, max: N, datum: &Datum) -> Result<(), DatumError> {
        let (least, greatest) = (min.into(), max.into());
        match datum.as_int() {
            Some(value) if (least..=greatest).contains(&value) => Ok(()),
            Some(value) => Err(mismatch(format!(
                "{value} is not between {least} and {greatest}"
            ))),
            None => Err(self.mismatch_with(datum)),
        }
    }

    fn field(&self, fields: &[OutlineKey], name: &str, value: &Datum) -> Result<(), DatumError> {
        match fields.iter().find(|field| field.name == name) {
            Some(field) => field
                .schema
                .accepts(value)
                .map_err(|error| error.within(name)),
            None => {
                let known = fields.iter().map(|field| format!("`{}`", field.name));
                let known = known.collect::<Vec<_>>().join(", ");
                Err(mismatch(format!(
                    "unknown field `{name}` of `{self}`; its fields: {known}"
                )))
            }
        }
    }

    /// Checks each element of a list and returns their number.
    fn check_elements(&self, element: &Self, datum: &Datum) -> Result<usize, DatumError> {
        let Some(count) = datum.count().filter(|_| !matches!(datum, Datum::Record(_))) else {
            return Err(self.mismatch_with(datum));
        };
        if element.accepts_packed(datum) {
            return Ok(count);
        }
        for index in 0..count {
            if let Some(datum) = datum.element(index) {
                element
                    .accepts(&datum)
                    .map_err(|error| error.within(index))?;
            }
        }
        Ok(count)
    }

    /// Returns whether the elements of bytes or packed numbers fit by their type alone.
    fn accepts_packed(&self, packed: &Datum) -> bool {
        let element = match packed {
            Datum::Bytes(_) => Shape::U8,
            Datum::Numbers(numbers) => numbers.shape(),
            Datum::Null
            | Datum::Bool(_)
            | Datum::Int(_)
            | Datum::Float(_)
            | Datum::Text(_)
            | Datum::List(_)
            | Datum::Record(_) => return false,
        };
        self.shape == element || matches!(self.shape, Shape::F32 | Shape::F64)
    }

    fn check(&self, fits: bool, datum: &Datum) -> Result<(), DatumError> {
        fits.then_some(()).ok_or_else(|| self.mismatch_with(datum))
    }

    fn mismatch_with(&self, found: &Datum) -> DatumError {
        mismatch(format!("expected `{self}`, found {}", found.kind()))
    }
}

fn mismatch(reason: String) -> DatumError {
    DatumError::new(DatumProblem::Mismatch(reason))
}
