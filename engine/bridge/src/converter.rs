//! Named converters: fields whose values mean the same on both sides of a bridge, and are written differently.

use asmotion_datum::{Datum, Schema, Shape};

use crate::units::Unit;

/// A converter of a field, decided once from its text.
#[derive(Clone, Debug, PartialEq)]
pub struct FieldConverter {
    /// Names of fields, outermost first; empty for the whole message. In a list, the next name is a field of every element.
    path: Vec<String>,
    how: Meaning,
}

#[derive(Clone, Debug, PartialEq)]
enum Meaning {
    /// Quantities in two units.
    Units { here: Unit, there: Unit },
    /// Values of an enumeration: the text here, and the value there.
    Words(Vec<(String, Datum)>),
}

/// The reason that a converter cannot be used.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum ConverterError {
    /// The text is not a converter.
    #[error(
        "`{text}` is no converter: write units, as in `rad = deg`, or values, as in `IDLE = 0, MOVING = 1`"
    )]
    Text {
        /// Text of the converter.
        text: String,
    },
    /// Units of different quantities.
    #[error("`{here}` is a unit of {quantity_here}, `{there}` of {quantity_there}")]
    Quantities {
        /// Unit here.
        here: &'static str,
        /// Unit there.
        there: &'static str,
        /// Quantity of `here`, such as length.
        quantity_here: &'static str,
        /// Quantity of `there`.
        quantity_there: &'static str,
    },
    /// A value that occurs twice, so that one direction is not decided.
    #[error("`{0}` occurs twice")]
    Twice(String),
    /// A side has no such field.
    #[error("there is no field `{path}` {side}")]
    NoField {
        /// Path of the field in the message.
        path: String,
        /// `here` or `there`.
        side: &'static str,
    },
    /// A field that cannot have the values.
    #[error("`{path}` is `{found}` {side}; it must be {wanted}")]
    Shape {
        /// Path of the field in the message.
        path: String,
        /// `here` or `there`.
        side: &'static str,
        /// Type of the field.
        found: String,
        /// Type that the converter needs.
        wanted: &'static str,
    },
}

impl FieldConverter {
    /// Reads a converter of the field at a path: `HERE = THERE` with two units, or pairs of values, separated by commas.
    ///
    /// # Errors
    /// [`ConverterError`].
    pub fn parse(path: &str, text: &str) -> Result<Self, ConverterError> {
        let wrong = || ConverterError::Text {
            text: text.to_owned(),
        };
        let pairs = text.split(',').map(|pair| {
            let (here, there) = pair.split_once('=')?;
            let (here, there) = (here.trim(), there.trim());
            (!here.is_empty() && !there.is_empty()).then_some((here, there))
        });
        let pairs: Vec<(&str, &str)> = pairs.collect::<Option<_>>().ok_or_else(wrong)?;
        let steps = path.split('.').filter(|step| !step.is_empty());
        let units = match *pairs {
            [(here, there)] => Unit::find(here).zip(Unit::find(there)),
            _ => None,
        };
        Ok(Self {
            path: steps.map(str::to_owned).collect(),
            how: match units {
                Some((here, there)) => units_of(here, there)?,
                None => words_of(&pairs)?,
            },
        })
    }

    /// Checks the field on both sides.
    ///
    /// # Errors
    /// [`ConverterError`].
    pub fn check(&self, here: &Schema, there: &Schema) -> Result<(), ConverterError> {
        let path = self.path.join(".");
        for (side, schema) in [("here", here), ("there", there)] {
            let found = field(schema, &self.path);
            let found = found.ok_or_else(|| ConverterError::NoField {
                path: path.clone(),
                side,
            })?;
            let wanted = match &self.how {
                Meaning::Units { .. } => (!is_float(found)).then_some("a floating-point number"),
                Meaning::Words(_) if side == "here" => {
                    (found.shape != Shape::Text).then_some("a string")
                }
                Meaning::Words(pairs) => {
                    let fits = pairs.iter().all(|(_, value)| found.accepts(value).is_ok());
                    (!fits).then_some("a type with these values")
                }
            };
            if let Some(wanted) = wanted {
                return Err(ConverterError::Shape {
                    path,
                    side,
                    found: found.to_string(),
                    wanted,
                });
            }
        }
        Ok(())
    }

    /// The values here, if the converter is one of an enumeration, with the path of the field.
    pub fn words(&self) -> Option<(String, Vec<&str>)> {
        let Meaning::Words(pairs) = &self.how else {
            return None;
        };
        let words = pairs.iter().map(|(here, _)| here.as_str());
        Some((self.path.join("."), words.collect()))
    }

    /// The schema of the messages here, with the type that the field has there.
    pub fn converted(&self, mut here: Schema, there: &Schema) -> Schema {
        if let (Some(field_here), Some(there)) =
            (field_mut(&mut here, &self.path), field(there, &self.path))
        {
            *field_here = there.clone();
        }
        here
    }

    /// Converts a message from here to there.
    ///
    /// # Errors
    /// A value that has no counterpart.
    pub fn to_there(&self, message: Datum) -> Result<Datum, String> {
        change(message, &self.path, &|value| match &self.how {
            Meaning::Units { here, there } => Ok(scaled(value, here.size / there.size)),
            Meaning::Words(pairs) => {
                let found = pairs.iter().find(|(here, _)| value.as_text() == Some(here));
                found
                    .map(|(_, there)| there.clone())
                    .ok_or_else(|| self.unknown(&value))
            }
        })
    }

    /// Converts a message from there to here.
    ///
    /// # Errors
    /// As [`to_there`](Self::to_there).
    pub fn to_here(&self, message: Datum) -> Result<Datum, String> {
        change(message, &self.path, &|value| match &self.how {
            Meaning::Units { here, there } => Ok(scaled(value, there.size / here.size)),
            Meaning::Words(pairs) => {
                let found = pairs.iter().find(|(_, there)| value == *there);
                found
                    .map(|(here, _)| Datum::text(here.as_str()))
                    .ok_or_else(|| self.unknown(&value))
            }
        })
    }

    fn unknown(&self, value: &Datum) -> String {
        let value = if let Some(text) = value.as_text() {
            text.to_owned()
        } else if let Some(number) = value.as_int() {
            number.to_string()
        } else if let Some(flag) = value.as_bool() {
            flag.to_string()
        } else {
            value.kind().to_owned()
        };
        format!("`{}`: the converter has no `{value}`", self.path.join("."))
    }
}

fn units_of(here: Unit, there: Unit) -> Result<Meaning, ConverterError> {
    if here.quantity != there.quantity {
        return Err(ConverterError::Quantities {
            here: here.name,
            there: there.name,
            quantity_here: here.quantity,
            quantity_there: there.quantity,
        });
    }
    Ok(Meaning::Units { here, there })
}

fn words_of(pairs: &[(&str, &str)]) -> Result<Meaning, ConverterError> {
    let mut words: Vec<(String, Datum)> = Vec::new();
    for (here, there) in pairs {
        let value = match *there {
            "true" => Datum::Bool(true),
            "false" => Datum::Bool(false),
            text => text.parse().map_or_else(|_| Datum::text(text), Datum::Int),
        };
        for (known, other) in &words {
            if known == here {
                return Err(ConverterError::Twice((*here).to_owned()));
            }
            if *other == value {
                return Err(ConverterError::Twice((*there).to_owned()));
            }
        }
        words.push(((*here).to_owned(), value));
    }
    Ok(Meaning::Words(words))
}

/// The element that the values of a list have; else the schema itself.
fn element(schema: &Schema) -> &Schema {
    if let Shape::List(element) | Shape::Array(element, _) = &schema.shape {
        element
    } else {
        schema
    }
}

fn field<'s>(schema: &'s Schema, path: &[String]) -> Option<&'s Schema> {
    let Some((step, rest)) = path.split_first() else {
        return Some(schema);
    };
    let Shape::Record(fields) = &element(schema).shape else {
        return None;
    };
    let found = fields.iter().find(|field| *field.name == **step)?;
    field(&found.schema, rest)
}

fn field_mut<'s>(schema: &'s mut Schema, path: &[String]) -> Option<&'s mut Schema> {
    let Some((step, rest)) = path.split_first() else {
        return Some(schema);
    };
    match &mut schema.shape {
        Shape::List(element) | Shape::Array(element, _) => field_mut(element, path),
        Shape::Record(fields) => {
            let found = fields.iter_mut().find(|field| *field.name == **step)?;
            field_mut(&mut found.schema, rest)
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
        | Shape::F32
        | Shape::F64
        | Shape::Text
        | Shape::Option(_) => None,
    }
}

fn is_float(schema: &Schema) -> bool {
    element(schema).shape.is_float()
}

/// Changes the value at a path, in every element of a list on the way.
fn change(
    data: Datum,
    path: &[String],
    how: &dyn Fn(Datum) -> Result<Datum, String>,
) -> Result<Datum, String> {
    let Some((step, rest)) = path.split_first() else {
        return how(data);
    };
    match data {
        Datum::Record(fields) => {
            let fields = fields.into_iter().map(|(name, value)| {
                let is_meant = *name == **step;
                let value = if is_meant {
                    change(value, rest, how)?
                } else {
                    value
                };
                Ok((name, value))
            });
            Ok(Datum::Record(fields.collect::<Result<_, String>>()?))
        }
        Datum::List(elements) => {
            let elements = elements.into_iter().map(|it| change(it, path, how));
            Ok(Datum::List(elements.collect::<Result<_, String>>()?))
        }
        // the schema of the message refuses it
        other @ (Datum::Null
        | Datum::Bool(_)
        | Datum::Int(_)
        | Datum::Float(_)
        | Datum::Text(_)
        | Datum::Bytes(_)
        | Datum::Numbers(_)) => Ok(other),
    }
}

/// Multiplies a number, or all numbers of a list.
fn scaled(value: Datum, factor: f64) -> Datum {
    if let Some(number) = value.as_float() {
        return Datum::Float(number * factor);
    }
    let Some(count) = value.count() else {
        return value;
    };
    let elements = (0..count).filter_map(|index| value.element(index));
    Datum::List(elements.map(|it| scaled(it.into_owned(), factor)).collect())
}

#[cfg(test)]
mod tests {
    use asmotion_datum::OutlineKey;

    use super::*;

    fn record(fields: &[(&'static str, Schema)]) -> Schema {
        let fields = fields.iter();
        let fields = fields.map(|(name, schema)| OutlineKey::new(*name, "", schema.clone()));
        Schema::record("test/Message", fields.collect())
    }

    fn plain(shape: Shape) -> Schema {
        Schema::plain(shape)
    }

    #[test]
    fn units_are_scaled_in_both_directions_also_in_lists() {
        let floats = record(&[("angles", Schema::many(plain(Shape::F64), None))]);
        let converter = FieldConverter::parse("angles", "rad = deg").unwrap();
        assert_eq!(converter.check(&floats, &floats), Ok(()));
        let message = |values: &[f64]| {
            let values = values.iter().copied().map(Datum::Float).collect();
            Datum::record([("angles", Datum::List(values))])
        };
        let here = message(&[std::f64::consts::PI, 0.0]);
        let there = message(&[180.0, 0.0]);
        assert_eq!(converter.to_there(here.clone()), Ok(there.clone()));
        assert_eq!(converter.to_here(there), Ok(here));
    }

    #[test]
    fn words_become_values_and_unknown_ones_are_refused() {
        let here = record(&[("state", plain(Shape::Text))]);
        let there = record(&[("state", plain(Shape::U8))]);
        let converter = FieldConverter::parse("state", "IDLE = 0, MOVING = 1").unwrap();
        assert_eq!(converter.check(&here, &there), Ok(()));
        assert_eq!(converter.converted(here, &there), there);
        let state = |value| Datum::record([("state", value)]);
        let moving = state(Datum::text("MOVING"));
        assert_eq!(converter.to_there(moving.clone()), Ok(state(Datum::Int(1))));
        assert_eq!(converter.to_here(state(Datum::Int(1))), Ok(moving));
        let unknown = converter.to_here(state(Datum::Int(7)));
        assert_eq!(unknown.unwrap_err(), "`state`: the converter has no `7`");
    }

    #[test]
    fn a_path_leads_through_lists() {
        let inner = record(&[("range", plain(Shape::F32))]);
        let schema = record(&[("beams", Schema::many(inner, None))]);
        let converter = FieldConverter::parse("beams.range", "m = mm").unwrap();
        assert_eq!(converter.check(&schema, &schema), Ok(()));
        let message = |range| {
            let beam = Datum::record([("range", Datum::Float(range))]);
            Datum::record([("beams", Datum::List(vec![beam]))])
        };
        assert_eq!(converter.to_there(message(1.5)), Ok(message(1500.0)));
    }

    #[test]
    fn wrong_converters_say_why() {
        let error = |path: &str, text: &str| {
            let here = record(&[("a", plain(Shape::F64)), ("b", plain(Shape::Text))]);
            let there = record(&[("a", plain(Shape::F64)), ("b", plain(Shape::U8))]);
            let converter = FieldConverter::parse(path, text);
            let checked = converter.and_then(|it| it.check(&here, &there));
            checked.unwrap_err().to_string()
        };
        assert!(error("a", "degrees").contains("is no converter"));
        assert_eq!(
            error("a", "rad = m"),
            "`rad` is a unit of angle, `m` of length"
        );
        assert_eq!(error("b", "X = 1, X = 2"), "`X` occurs twice");
        assert_eq!(error("b", "X = 1, Y = 1"), "`1` occurs twice");
        assert_eq!(error("c", "rad = deg"), "there is no field `c` here");
        assert!(error("b", "rad = deg").contains("it must be a floating-point number"));
        assert!(error("b", "X = 300").contains("a type with these values"));
        assert!(error("a", "X = 3").contains("it must be a string"));
    }
}
