//! Conversions between messages of different schemas: by field names or, where there are no names, by shape.

use std::borrow::Cow;

use asmotion_datum::{Datum, OutlineKey, Schema, Shape};

/// A conversion from one schema to another, decided once from the schemas.
#[derive(Clone, Debug, PartialEq)]
pub enum Conversion {
    /// No change.
    Same,
    /// A record of these fields, each converted from the source's field with the same name.
    Fields(Vec<(String, Conversion)>),
    /// A record whose field of this name is converted from the source; other fields get their initial values.
    Into(String, Box<Conversion>),
    /// The conversion of this field of the source.
    OutOf(String, Box<Conversion>),
    /// The conversion of every element of a list.
    Each(Box<Conversion>),
    /// Two conversions in sequence.
    Then(Box<Conversion>, Box<Conversion>),
}

/// The side of a conversion that must be complete.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Use {
    /// Every field of the source is used: a request becomes a message.
    All,
    /// Every field of the target is filled: a message becomes a response.
    Fill,
}

impl Conversion {
    /// Finds the conversion between two schemas. Returns `None` if there is none, or if it is ambiguous.
    pub fn between(from: &Schema, to: &Schema, usage: Use) -> Option<Self> {
        match (&from.shape, &to.shape) {
            (Shape::Any, _) | (_, Shape::Any) => Some(Self::Same),
            (Shape::Record(source), Shape::Record(target)) => by_name(source, target, usage)
                .or_else(|| out_of(source, to, usage))
                .or_else(|| into(from, target, usage)),
            (Shape::Record(source), _) => out_of(source, to, usage),
            (_, Shape::Record(target)) => into(from, target, usage),
            (
                Shape::List(source) | Shape::Array(source, _),
                Shape::List(target) | Shape::Array(target, _),
            ) => {
                let counts = (count(&from.shape), count(&to.shape));
                if matches!(counts, (Some(here), Some(there)) if here != there) {
                    return None;
                }
                Self::between(source, target, usage).map(Self::each)
            }
            (Shape::Option(source), Shape::Option(target)) => {
                Self::between(source, target, usage).filter(|inner| *inner == Self::Same)
            }
            (source, target) => widens(source, target).then_some(Self::Same),
        }
    }

    /// The same conversion for every element of a list.
    pub fn each(self) -> Self {
        if let Self::Same = self {
            Self::Same
        } else {
            Self::Each(Box::new(self))
        }
    }

    /// This conversion, followed by another.
    pub fn then(self, next: Self) -> Self {
        match (self, next) {
            (Self::Same, only) | (only, Self::Same) => only,
            (first, next) => Self::Then(Box::new(first), Box::new(next)),
        }
    }

    /// Restricts a conversion to a part of the message: its source for `Use::Fill`, its target for `Use::All`.
    pub fn at_path(path: Option<&str>, conversion: Self, usage: Use) -> Self {
        let steps = path.into_iter().flat_map(|path| path.rsplit('.'));
        steps.fold(conversion, |inner, step| match usage {
            Use::Fill => Self::OutOf(step.to_owned(), Box::new(inner)),
            Use::All => Self::Into(step.to_owned(), Box::new(inner)),
        })
    }

    /// The path in the source from which the part at this path of the target comes; `None` if it comes from no single part.
    pub(crate) fn source_path(&self, target: &str) -> Option<String> {
        let (first, rest) = target.split_once('.').unwrap_or((target, ""));
        let within = |outer: &str, inner: String| match inner.as_str() {
            "" => outer.to_owned(),
            inner => format!("{outer}.{inner}"),
        };
        match self {
            Self::Same => Some(target.to_owned()),
            Self::Fields(_) if target.is_empty() => Some(String::new()),
            Self::Fields(fields) => {
                let (_, inner) = fields.iter().find(|(name, _)| name == first)?;
                Some(within(first, inner.source_path(rest)?))
            }
            Self::Into(field, inner) if field == first => inner.source_path(rest),
            Self::Into(..) => None,
            Self::OutOf(field, inner) => Some(within(field, inner.source_path(target)?)),
            Self::Each(_) if target.is_empty() => Some(String::new()),
            Self::Each(inner) => Some(within(first, inner.source_path(rest)?)),
            Self::Then(first, next) => first.source_path(&next.source_path(target)?),
        }
    }

    /// Converts data as [`apply`](Self::apply) does, without a copy of the parts that stay as they are.
    pub fn convert(&self, data: Datum) -> Datum {
        match (self, data) {
            (Self::Same, data) => data,
            (Self::Fields(fields), Datum::Record(mut entries)) => {
                let converted = fields.iter().map(|(name, inner)| {
                    let found = entries.iter_mut().find(|(entry, _)| entry == name);
                    match found.map(std::mem::take) {
                        Some((name, part)) => (name, inner.convert(part)),
                        None => (Cow::Owned(name.clone()), inner.convert(Datum::Null)),
                    }
                });
                Datum::Record(converted.collect())
            }
            (Self::Into(field, inner), data) => {
                Datum::record([(field.clone(), inner.convert(data))])
            }
            (Self::Each(inner), Datum::List(elements)) => {
                let elements = elements.into_iter();
                Datum::List(elements.map(|element| inner.convert(element)).collect())
            }
            (Self::Fields(_) | Self::OutOf(..) | Self::Each(_), data) => self.apply(&data),
            (Self::Then(first, next), data) => next.convert(first.convert(data)),
        }
    }

    /// Converts data. Missing parts become null, which no type accepts, and fields that the source's type does not have are
    /// not looked at: check the data first.
    pub fn apply(&self, data: &Datum) -> Datum {
        match self {
            Self::Same => data.clone(),
            Self::Fields(fields) => {
                let part = |name: &str| data.get(name).unwrap_or(Cow::Owned(Datum::Null));
                let fields = fields.iter();
                Datum::record(fields.map(|(name, inner)| (name.clone(), inner.apply(&part(name)))))
            }
            Self::Into(field, inner) => Datum::record([(field.clone(), inner.apply(data))]),
            // not a record: the caller passed the field's value without a record around it
            Self::OutOf(field, inner) => {
                if let Datum::Record(_) = data {
                    let part = data.get(field).unwrap_or(Cow::Owned(Datum::Null));
                    inner.apply(&part)
                } else {
                    inner.apply(data)
                }
            }
            Self::Each(inner) => {
                let elements = (0..data.count().unwrap_or(0)).filter_map(|at| data.element(at));
                Datum::List(elements.map(|element| inner.apply(&element)).collect())
            }
            Self::Then(first, next) => next.apply(&first.apply(data)),
        }
    }
}

fn by_name(source: &[OutlineKey], target: &[OutlineKey], usage: Use) -> Option<Conversion> {
    let required = match usage {
        Use::All => source,
        Use::Fill => target,
    };
    let find = |fields: &[OutlineKey], name: &str| {
        let field = fields.iter().find(|field| field.name == name)?;
        Some(field.schema.clone())
    };
    let fields = required.iter().map(|field| {
        let name = &*field.name;
        let inner = Conversion::between(&find(source, name)?, &find(target, name)?, usage)?;
        Some((name.to_owned(), inner))
    });
    fields.collect::<Option<_>>().map(Conversion::Fields)
}

/// Uses the only field of a record in its place.
fn out_of(source: &[OutlineKey], to: &Schema, usage: Use) -> Option<Conversion> {
    let [only] = source else { return None };
    let inner = Conversion::between(&only.schema, to, usage)?;
    Some(Conversion::OutOf(only.name.to_string(), Box::new(inner)))
}

/// The only field of a record that accepts the data.
fn into(from: &Schema, target: &[OutlineKey], usage: Use) -> Option<Conversion> {
    if usage == Use::Fill && target.len() > 1 {
        return None;
    }
    let candidates = target.iter().filter_map(|field| {
        let inner = Conversion::between(from, &field.schema, usage)?;
        // a field within a field would be too surprising
        (!matches!(inner, Conversion::Into(..))).then_some((field, inner))
    });
    let mut taken = candidates.collect::<Vec<_>>().into_iter();
    let (Some((field, inner)), None) = (taken.next(), taken.next()) else {
        return None;
    };
    Some(Conversion::Into(field.name.to_string(), Box::new(inner)))
}

fn count(shape: &Shape) -> Option<usize> {
    if let Shape::Array(_, count) = shape {
        Some(*count)
    } else {
        None
    }
}

/// Returns whether numbers of one type may be converted to another. Each value is still checked.
fn widens(from: &Shape, to: &Shape) -> bool {
    let (whole, real) = (Shape::is_integer, Shape::is_float);
    from == to || (whole(from) && (whole(to) || real(to))) || (real(from) && real(to))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn record(fields: &[(&'static str, Schema)]) -> Schema {
        let fields = fields.iter().map(|(name, schema)| OutlineKey {
            name: (*name).into(),
            doc: "".into(),
            schema: schema.clone(),
            initial: Datum::Null,
        });
        Schema::record("", fields.collect())
    }

    fn plain(shape: Shape) -> Schema {
        Schema::plain(shape)
    }

    fn floats(count: Option<usize>) -> Schema {
        Schema::many(plain(Shape::F64), count)
    }

    fn stamped(goal: Schema) -> Schema {
        let time = record(&[("sec", plain(Shape::I32)), ("nanosec", plain(Shape::U32))]);
        record(&[("stamp", time), ("position", goal)])
    }

    fn list(values: &[f64]) -> Datum {
        Datum::List(values.iter().copied().map(Datum::Float).collect())
    }

    /// Converts data, if there is a conversion.
    fn convert(from: &Schema, to: &Schema, how: Use, data: &Datum) -> Option<Datum> {
        let conversion = Conversion::between(from, to, how)?;
        let converted = conversion.apply(data);
        assert_eq!(conversion.convert(data.clone()), converted);
        Some(converted)
    }

    #[test]
    fn an_argument_goes_into_the_field_of_its_name_or_else_of_its_shape() {
        let command = stamped(floats(Some(2)));
        let expected = Some(Datum::record([("position", list(&[1.0, 2.0]))]));
        for name in ["position", "values"] {
            let argument = record(&[(name, floats(None))]);
            let data = Datum::record([(name, list(&[1.0, 2.0]))]);
            assert_eq!(
                convert(&argument, &command, Use::All, &data),
                expected,
                "{name}"
            );
        }
        let bare = list(&[1.0, 2.0]);
        assert_eq!(convert(&floats(None), &command, Use::All, &bare), expected);
    }

    #[test]
    fn an_argument_of_one_field_is_a_plain_message() {
        let argument = record(&[("period", plain(Shape::F64))]);
        let data = Datum::record([("period", Datum::Float(0.05))]);
        let message = convert(&argument, &plain(Shape::F64), Use::All, &data);
        assert_eq!(message, Some(Datum::Float(0.05)));
    }

    #[test]
    fn a_result_takes_the_fields_it_has() {
        let data = Datum::record([
            ("stamp", Datum::Null),
            ("position", list(&[0.5])),
            ("velocity", list(&[0.1])),
        ]);
        let status = record(&[
            ("stamp", plain(Shape::I64)),
            ("position", floats(Some(5))),
            ("velocity", floats(Some(5))),
        ]);
        let result = record(&[("position", floats(None))]);
        let expected = Some(Datum::record([("position", list(&[0.5]))]));
        assert_eq!(convert(&status, &result, Use::Fill, &data), expected);
    }

    #[test]
    fn nothing_gets_lost_and_nothing_is_made_up() {
        let argument = record(&[("position", floats(None)), ("speed", plain(Shape::F64))]);
        let command = stamped(floats(None));
        assert_eq!(Conversion::between(&argument, &command, Use::All), None);
        let result = record(&[("position", floats(None)), ("load", plain(Shape::F64))]);
        assert_eq!(Conversion::between(&command, &result, Use::Fill), None);
        // ambiguous: the data fit both fields
        let two = record(&[("a", floats(None)), ("b", floats(None))]);
        assert_eq!(Conversion::between(&floats(None), &two, Use::All), None);
        assert_eq!(
            Conversion::between(&floats(Some(5)), &floats(Some(6)), Use::All),
            None
        );
    }

    #[test]
    fn a_run_is_converted_element_by_element() {
        let status = record(&[("position", plain(Shape::F64)), ("load", plain(Shape::F64))]);
        let wanted = record(&[("all", floats(None))]);
        let part = Conversion::at_path(Some("position"), Conversion::Same, Use::Fill);
        let all = Conversion::between(&floats(None), &wanted, Use::Fill);
        let data = |position| Datum::record([("position", Datum::Float(position))]);
        let data = Datum::List(vec![data(1.0), data(2.0)]);
        let expected = Datum::record([("all", list(&[1.0, 2.0]))]);
        let conversion = all.map(|all| part.each().then(all));
        assert_eq!(conversion.map(|it| it.apply(&data)), Some(expected));
        let records = Schema::many(status, None);
        let names = Schema::many(record(&[("load", plain(Shape::F64))]), None);
        let picked = convert(&records, &names, Use::Fill, &Datum::List(Vec::new()));
        assert_eq!(picked, Some(Datum::List(Vec::new())));
    }

    #[test]
    fn a_part_of_the_message_has_a_place_in_the_argument() {
        let source = |from: &Schema, to: &Schema, target: &str| {
            let conversion = Conversion::between(from, to, Use::All);
            conversion.and_then(|it| it.source_path(target))
        };
        let of = |path: &str| Some(path.to_owned());
        let period = record(&[("period", plain(Shape::F64))]);
        let number = record(&[("data", plain(Shape::F64))]);
        assert_eq!(source(&period, &number, "data"), of("period"));
        assert_eq!(source(&period, &plain(Shape::F64), ""), of("period"));
        let command = stamped(floats(None));
        let positions = record(&[("position", floats(None))]);
        assert_eq!(source(&positions, &command, "position.1"), of("position.1"));
        assert_eq!(source(&floats(None), &command, "position.1"), of("1"));
        assert_eq!(source(&positions, &command, "stamp.sec"), None);
        let out = Conversion::at_path(Some("pose.x"), Conversion::Same, Use::Fill).each();
        assert_eq!(out.source_path("3"), of("3.pose.x"));
    }

    #[test]
    fn a_path_leads_into_a_message_and_out_of_it() {
        let out = Conversion::at_path(Some("pose.x"), Conversion::Same, Use::Fill);
        let data = Datum::record([("pose", Datum::record([("x", Datum::Int(3))]))]);
        assert_eq!(out.apply(&data), Datum::Int(3));
        let into = Conversion::at_path(Some("pose.x"), Conversion::Same, Use::All);
        assert_eq!(into.apply(&Datum::Int(3)), data);
    }
}
