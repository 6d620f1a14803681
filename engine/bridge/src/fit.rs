//! Checks data against a schema.

use asmotion_datum::{Datum, OutlineKey, Schema, Shape};

use crate::conversion::Conversion;

/// The first place where data do not fit a schema.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{}{problem}", location(.path))]
pub struct SchemaMisfit {
    path: String,
    /// The expected and the actual value, as text.
    problem: String,
}

fn location(path: &str) -> String {
    if path.is_empty() {
        return String::new();
    }
    format!("`{path}`: ")
}

/// Checks the argument of an operation. The value of its only field may stand for the record. An empty record is no argument
/// unless the operation has no parameters: the target would carry out a command that nobody has given.
///
/// # Errors
/// The first place where it does not fit.
pub(crate) fn check_argument(argument: &Datum, request: &Schema) -> Result<(), SchemaMisfit> {
    match (argument, &request.shape) {
        (Datum::Record(entries), Shape::Record(fields))
            if entries.is_empty() && !fields.is_empty() =>
        {
            Err(no_field(fields))
        }
        (Datum::Record(_), _) => check_fit(argument, request),
        (_, Shape::Record(fields)) if let [only] = fields.as_slice() => {
            check_fit(argument, &only.schema)
        }
        _ => check_fit(argument, request),
    }
}

/// Checks that data fit a schema. Fields of a record may be omitted; they have their initial values.
///
/// # Errors
/// The first place where they do not fit.
pub fn check_fit(data: &Datum, schema: &Schema) -> Result<(), SchemaMisfit> {
    let fits = match &schema.shape {
        Shape::Any => true,
        Shape::Bool => data.as_bool().is_some(),
        Shape::Text => data.as_text().is_some(),
        Shape::F32 | Shape::F64 => data.as_float().is_some(),
        Shape::I8 => is_integer::<i8>(data),
        Shape::I16 => is_integer::<i16>(data),
        Shape::I32 => is_integer::<i32>(data),
        Shape::I64 => is_integer::<i64>(data),
        Shape::U8 => is_integer::<u8>(data),
        Shape::U16 => is_integer::<u16>(data),
        Shape::U32 => is_integer::<u32>(data),
        Shape::U64 => is_integer::<u64>(data),
        Shape::Option(_) if *data == Datum::Null => true,
        Shape::Option(some) => return check_fit(data, some),
        Shape::List(element) => return elements(data, element, None, schema),
        Shape::Array(element, count) => return elements(data, element, Some(*count), schema),
        Shape::Record(fields) => return record(data, fields, schema),
    };
    if fits {
        return Ok(());
    }
    Err(misfit(schema, data))
}

fn is_integer<T: TryFrom<i64>>(data: &Datum) -> bool {
    data.as_int()
        .is_some_and(|value| T::try_from(value).is_ok())
}

fn elements(
    data: &Datum,
    element: &Schema,
    count: Option<usize>,
    schema: &Schema,
) -> Result<(), SchemaMisfit> {
    let found = match data {
        Datum::List(_) | Datum::Numbers(_) | Datum::Bytes(_) => data.count().unwrap_or(0),
        Datum::Null
        | Datum::Bool(_)
        | Datum::Int(_)
        | Datum::Float(_)
        | Datum::Text(_)
        | Datum::Record(_) => return Err(misfit(schema, data)),
    };
    if let Some(expected) = count.filter(|wanted| *wanted != found) {
        return Err(wrong_count(expected, found));
    }
    for index in 0..found {
        if let Some(item) = data.element(index) {
            check_fit(&item, element).map_err(|misfit| misfit.in_field(&index.to_string()))?;
        }
    }
    Ok(())
}

/// The error for a list with the wrong number of elements.
pub(crate) fn wrong_count(expected: usize, found: usize) -> SchemaMisfit {
    SchemaMisfit {
        path: String::new(),
        problem: format!("expected a list of {expected}, found one of {found}"),
    }
}

fn record(data: &Datum, fields: &[OutlineKey], schema: &Schema) -> Result<(), SchemaMisfit> {
    let Datum::Record(entries) = data else {
        return Err(misfit(schema, data));
    };
    for (name, value) in entries {
        match fields.iter().find(|field| field.name == *name) {
            Some(field) => {
                check_fit(value, &field.schema).map_err(|misfit| misfit.in_field(name))?;
            }
            None => {
                return Err(unknown_field(name, fields));
            }
        }
    }
    Ok(())
}

fn misfit(schema: &Schema, data: &Datum) -> SchemaMisfit {
    SchemaMisfit {
        path: String::new(),
        problem: format!("expected `{schema}`, found {}", data.kind()),
    }
}

fn no_field(known: &[OutlineKey]) -> SchemaMisfit {
    SchemaMisfit {
        path: String::new(),
        problem: format!("the argument is empty, {}", expected_field(known)),
    }
}

fn expected_field(known: &[OutlineKey]) -> String {
    let names = known.iter().map(|field| format!("`{}`", field.name));
    let names: Vec<String> = names.collect();
    match names.as_slice() {
        [] => "there are no fields".to_owned(),
        [only] => format!("expected {only}"),
        several => format!("expected one of {}", several.join(", ")),
    }
}

fn unknown_field(name: &str, known: &[OutlineKey]) -> SchemaMisfit {
    let expected = expected_field(known);
    SchemaMisfit {
        path: String::new(),
        problem: format!("unknown field `{name}`, {expected}"),
    }
}

impl SchemaMisfit {
    /// The misfit of a converted message, with the path in the data that were converted.
    pub(crate) fn at_source_of(self, conversion: &Conversion) -> Self {
        let path = conversion.source_path(&self.path).unwrap_or(self.path);
        Self { path, ..self }
    }

    pub(crate) fn in_field(mut self, step: &str) -> Self {
        self.path = match self.path.as_str() {
            "" => step.to_owned(),
            inner => format!("{step}.{inner}"),
        };
        self
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use asmotion_datum::OutlineKey;

    fn description(data: &Datum, schema: &Schema) -> String {
        check_fit(data, schema).unwrap_err().to_string()
    }

    #[test]
    fn it_says_where_data_does_not_fit() {
        let floats = Schema::many(Schema::plain(Shape::F64), Some(2));
        let field = |name: &'static str, schema| OutlineKey {
            name: name.into(),
            doc: "".into(),
            schema,
            initial: Datum::Null,
        };
        let byte = Schema::plain(Shape::U8);
        let command = Schema::record("arm/Command", vec![field("goal", floats), field("n", byte)]);
        let goal = |goal| Datum::record([("goal", goal)]);
        let pair = |second| goal(Datum::List(vec![Datum::Float(0.5), second]));
        assert_eq!(check_fit(&pair(Datum::Int(1)), &command), Ok(()));
        assert_eq!(check_fit(&Datum::record::<String>([]), &command), Ok(()));
        assert_eq!(
            description(&pair(Datum::text("far")), &command),
            "`goal.1`: expected `float64`, found a string"
        );
        assert_eq!(
            description(&goal(Datum::List(Vec::new())), &command),
            "`goal`: expected a list of 2, found one of 0"
        );
        assert_eq!(
            description(&Datum::record([("n", Datum::Int(256))]), &command),
            "`n`: expected `uint8`, found an integer"
        );
        assert_eq!(
            description(&Datum::record([("speed", Datum::Int(1))]), &command),
            "unknown field `speed`, expected one of `goal`, `n`"
        );
    }

    #[test]
    fn an_empty_argument_is_no_command() {
        let number = || OutlineKey::new("n", "", Schema::plain(Shape::U8));
        let goal = || OutlineKey::new("goal", "", Schema::plain(Shape::F64));
        let empty = Datum::record::<String>([]);
        let check = |argument: &Datum, fields: Vec<OutlineKey>| {
            let checked = check_argument(argument, &Schema::record("arm/Command", fields));
            checked.map_err(|misfit| misfit.to_string())
        };
        let one = "the argument is empty, expected `n`".to_owned();
        assert_eq!(check(&empty, vec![number()]), Err(one));
        let two = "the argument is empty, expected one of `goal`, `n`".to_owned();
        assert_eq!(check(&empty, vec![goal(), number()]), Err(two));
        // no parameters, a part of the fields, and the value of the only field
        assert_eq!(check(&empty, vec![]), Ok(()));
        let part = Datum::record([("n", Datum::Int(1))]);
        assert_eq!(check(&part, vec![goal(), number()]), Ok(()));
        assert_eq!(check(&Datum::Int(1), vec![number()]), Ok(()));
    }
}
