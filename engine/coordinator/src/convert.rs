//! Converts between data and values of the machine.

use asmotion_datum::{Datum, FieldName};
use asmotion_lang::ir::{DomainElements, DomainId, Program, ValueShape};
use asmotion_lang::machine::Naming;
use asmotion_lang::value::{Atom, Value};
use std::iter::repeat_n;

/// Converts a datum to a value of this shape. Returns `None` if it does not fit. Texts name enum literals, and a record
/// with one field stands for that field.
pub(crate) fn value_of(datum: &Datum, shape: &ValueShape, program: &Program) -> Option<Value> {
    if let ValueShape::Domain(domain) = shape
        && let Some(wider) = wider_shape(*domain, program)
    {
        // the machine tests whether the value is an element
        return value_of(datum, &wider, program);
    }
    match datum {
        Datum::Null => Some(Value::Undef),
        Datum::Bool(_) | Datum::Int(_) | Datum::Float(_) | Datum::Text(_) => {
            scalar_value(datum, shape, program)
        }
        Datum::List(_) | Datum::Numbers(_) | Datum::Bytes(_) => list_value(datum, shape, program),
        Datum::Record(fields) => record_value(fields, shape, program),
    }
}

fn scalar_value(datum: &Datum, shape: &ValueShape, program: &Program) -> Option<Value> {
    match (datum, shape) {
        (Datum::Bool(truth), ValueShape::Bool | ValueShape::Any) => Some(Value::Bool(*truth)),
        (Datum::Int(number), ValueShape::Int | ValueShape::Any) => Some(Value::Int(*number)),
        (Datum::Int(number), ValueShape::Natural) => (*number >= 0).then_some(Value::Int(*number)),
        (Datum::Int(number), ValueShape::Real) => Some(Value::real(*number as f64)),
        (Datum::Int(number), ValueShape::Domain(domain)) => integer_of(*number, *domain, program),
        (Datum::Float(number), ValueShape::Real | ValueShape::Any) => Some(Value::real(*number)),
        (Datum::Text(text), ValueShape::Text | ValueShape::Any) => Some(Value::text(text.as_str())),
        (Datum::Text(text), ValueShape::Char) => character(text).map(Value::Char),
        (Datum::Text(text), ValueShape::Domain(domain)) => literal_value(text, *domain, program),
        _ => None,
    }
}

/// The only character of a text.
fn character(text: &str) -> Option<char> {
    let mut characters = text.chars();
    characters.next().filter(|_| characters.next().is_none())
}

/// Converts a list, packed numbers or bytes.
fn list_value(datum: &Datum, shape: &ValueShape, program: &Program) -> Option<Value> {
    let items = (0..datum.count()?).map_while(|index| datum.element(index));
    let each = |shape: &ValueShape| {
        let values = items.clone().map(|item| value_of(&item, shape, program));
        values.collect::<Option<Vec<_>>>()
    };
    match shape {
        ValueShape::Seq(item) => each(item).map(Value::seq),
        ValueShape::Any => each(shape).map(Value::seq),
        ValueShape::Set(item) => each(item).map(Value::set),
        ValueShape::Bag(item) => each(item).map(Value::bag),
        ValueShape::Tuple(shapes) if datum.count() == Some(shapes.len()) => {
            let values = items.zip(shapes);
            let values = values.map(|(item, shape)| value_of(&item, shape, program));
            values.collect::<Option<Vec<_>>>().map(Value::tuple)
        }
        ValueShape::Tuple(_)
        | ValueShape::Bool
        | ValueShape::Int
        | ValueShape::Natural
        | ValueShape::Real
        | ValueShape::Char
        | ValueShape::Text
        | ValueShape::Complex
        | ValueShape::Rule
        | ValueShape::Domain(_)
        | ValueShape::Map(..) => None,
    }
}

/// Converts a record: to a map of its fields, to a tuple of its fields in order, or to the value of its only field.
fn record_value(
    fields: &[(FieldName, Datum)],
    shape: &ValueShape,
    program: &Program,
) -> Option<Value> {
    match (shape, fields) {
        (ValueShape::Map(key, item), _) => map_value(fields, key, item, program),
        (ValueShape::Any, []) | (ValueShape::Any, [_, _, ..]) => {
            map_value(fields, &ValueShape::Text, shape, program)
        }
        (ValueShape::Tuple(shapes), _) if fields.len() == shapes.len() => {
            let items = fields.iter().zip(shapes);
            let items = items.map(|((_, item), shape)| value_of(item, shape, program));
            items.collect::<Option<Vec<_>>>().map(Value::tuple)
        }
        (shape, [(_, only)]) => value_of(only, shape, program),
        _ => None,
    }
}

fn map_value(
    fields: &[(FieldName, Datum)],
    key: &ValueShape,
    item: &ValueShape,
    program: &Program,
) -> Option<Value> {
    let pair = |(name, value): &(FieldName, Datum)| {
        let key = value_of(&Datum::text(&**name), key, program)?;
        Some((key, value_of(value, item, program)?))
    };
    let pairs = fields.iter().map(pair).collect::<Option<Vec<_>>>();
    pairs.map(Value::map)
}

/// The shape of the values among which the elements of a domain are, if the program does not list the elements.
fn wider_shape(domain: DomainId, program: &Program) -> Option<ValueShape> {
    let domain = program.domains.get(domain.0 as usize)?;
    match domain.elements {
        DomainElements::Ints { .. } | DomainElements::Atoms { .. } => None,
        DomainElements::Computed(_) | DomainElements::Undefined | DomainElements::Open => {
            Some(domain.base.map_or(ValueShape::Any, ValueShape::Domain))
        }
    }
}

/// The integer, if the domain contains it.
fn integer_of(number: i64, domain: DomainId, program: &Program) -> Option<Value> {
    let elements = &program.domains.get(domain.0 as usize)?.elements;
    let &DomainElements::Ints { low, high } = elements else {
        return None;
    };
    (low..=high).contains(&number).then_some(Value::Int(number))
}

/// The enum literal or constant with this name in a domain, or in the domain of which it is a subset.
pub(crate) fn literal_value(name: &str, domain: DomainId, program: &Program) -> Option<Value> {
    let domain = program.domains.get(domain.0 as usize)?;
    let DomainElements::Atoms { first, count } = domain.elements else {
        return literal_value(name, domain.base?, program);
    };
    let names = program
        .symbols
        .atoms
        .get(first.0 as usize..(first.0 + count) as usize)?;
    let index = names.iter().position(|known| &**known == name)?;
    Some(Value::Atom(Atom(first.0 + index as u32)))
}

/// Converts a value to a datum; atoms and rules are represented by their names, and complex numbers by their text.
pub(crate) fn datum_of(value: &Value, naming: &Naming<'_>) -> Datum {
    let each = |items: &mut dyn Iterator<Item = &Value>| {
        Datum::List(items.map(|item| datum_of(item, naming)).collect())
    };
    match value {
        Value::Undef => Datum::Null,
        Value::Bool(truth) => Datum::Bool(*truth),
        Value::Int(number) => Datum::Int(*number),
        Value::Real(number) => Datum::Float(number.get()),
        Value::Text(text) => Datum::text(text.as_str()),
        Value::Char(character) => Datum::text(character.to_string()),
        Value::Tuple(items) | Value::Seq(items) => each(&mut items.iter()),
        Value::Set(items) => each(&mut items.iter()),
        Value::Bag(items) => each(
            &mut items
                .iter()
                .flat_map(|(item, count)| repeat_n(item, *count)),
        ),
        Value::Map(pairs) => match record_of(pairs.iter(), naming) {
            Some(fields) => Datum::Record(fields),
            None => Datum::text(value.show(naming).to_string()),
        },
        Value::Atom(_) | Value::Rule(_) | Value::Complex(_) => {
            Datum::text(value.show(naming).to_string())
        }
    }
}

/// The fields of a record, if all keys of a map are texts or elements, which have names.
fn record_of<'a>(
    pairs: impl Iterator<Item = (&'a Value, &'a Value)>,
    naming: &Naming<'_>,
) -> Option<Vec<(FieldName, Datum)>> {
    let field = |(key, value): (&Value, &Value)| {
        let name = match key {
            Value::Text(name) => name.to_string(),
            Value::Atom(_) => key.show(naming).to_string(),
            Value::Undef
            | Value::Bool(_)
            | Value::Int(_)
            | Value::Real(_)
            | Value::Char(_)
            | Value::Rule(_)
            | Value::Complex(_)
            | Value::Tuple(_)
            | Value::Seq(_)
            | Value::Set(_)
            | Value::Bag(_)
            | Value::Map(_) => return None,
        };
        Some((name.into(), datum_of(value, naming)))
    };
    pairs.map(field).collect()
}
