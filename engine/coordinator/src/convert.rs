//! Converts between data and values of the machine.

use asmotion_datum::Datum;
use asmotion_lang::ir::{DomainElements, DomainId, Program, ValueShape};
use asmotion_lang::machine::Naming;
use asmotion_lang::value::{Atom, Value};
use std::borrow::Cow;

/// Converts a datum to a value of this shape. Returns `None` if it does not fit. Texts name enum literals.
pub(crate) fn value_of(datum: &Datum, shape: &ValueShape, program: &Program) -> Option<Value> {
    let each = |items: &[Datum], shape: &ValueShape| {
        items
            .iter()
            .map(|item| value_of(item, shape, program))
            .collect::<Option<Vec<_>>>()
    };
    match (datum, shape) {
        (Datum::Null, _) => Some(Value::Undef),
        (Datum::Bool(truth), ValueShape::Bool | ValueShape::Any) => Some(Value::Bool(*truth)),
        (Datum::Int(number), ValueShape::Int | ValueShape::Any) => Some(Value::Int(*number)),
        (Datum::Int(number), ValueShape::Natural) => (*number >= 0).then_some(Value::Int(*number)),
        (Datum::Int(number), ValueShape::Real) => Some(Value::real(*number as f64)),
        (Datum::Int(number), ValueShape::Domain(domain)) => integer_of(*number, *domain, program),
        (Datum::Float(number), ValueShape::Real | ValueShape::Any) => Some(Value::real(*number)),
        (Datum::Text(text), ValueShape::Text | ValueShape::Any) => Some(Value::text(text.as_str())),
        (Datum::Text(text), ValueShape::Domain(domain)) => literal_value(text, *domain, program),
        (Datum::List(items), ValueShape::Seq(item)) => each(items, item).map(Value::seq),
        (Datum::List(items), ValueShape::Set(item)) => each(items, item).map(Value::set),
        (Datum::List(items), ValueShape::Bag(item)) => each(items, item).map(Value::bag),
        (Datum::List(items), ValueShape::Tuple(shapes)) if items.len() == shapes.len() => {
            let items = items
                .iter()
                .zip(shapes)
                .map(|(item, shape)| value_of(item, shape, program));
            items.collect::<Option<Vec<_>>>().map(Value::tuple)
        }
        // a record is a map of its fields, if any value is accepted
        (Datum::Record(fields), ValueShape::Any) if fields.len() != 1 => {
            let field = |(name, value): &(Cow<'_, str>, Datum)| {
                Some((Value::text(&**name), value_of(value, shape, program)?))
            };
            fields
                .iter()
                .map(field)
                .collect::<Option<Vec<_>>>()
                .map(Value::map)
        }
        (Datum::Record(fields), ValueShape::Map(..)) => {
            let ValueShape::Map(key, item) = shape else {
                return None;
            };
            let field = |(name, value): &(Cow<'_, str>, Datum)| {
                let key = value_of(&Datum::text(&**name), key, program)?;
                Some((key, value_of(value, item, program)?))
            };
            fields
                .iter()
                .map(field)
                .collect::<Option<Vec<_>>>()
                .map(Value::map)
        }
        // and a tuple of its fields, in order, if a tuple is expected
        (Datum::Record(fields), ValueShape::Tuple(shapes)) if fields.len() == shapes.len() => {
            let items = fields
                .iter()
                .zip(shapes)
                .map(|((_, item), shape)| value_of(item, shape, program));
            items.collect::<Option<Vec<_>>>().map(Value::tuple)
        }
        (Datum::List(items), ValueShape::Any) => each(items, shape).map(Value::seq),
        // a message with one field stands for that field
        (Datum::Record(fields), shape) => match fields.as_slice() {
            [(_, only)] => value_of(only, shape, program),
            _ => None,
        },
        _ => None,
    }
}

fn integer_of(number: i64, domain: DomainId, program: &Program) -> Option<Value> {
    match program.domains.get(domain.0 as usize)?.elements {
        DomainElements::Ints { low, high } => {
            (low..=high).contains(&number).then_some(Value::Int(number))
        }
        DomainElements::Computed(_) | DomainElements::Undefined | DomainElements::Open => {
            Some(Value::Int(number))
        }
        DomainElements::Atoms { .. } => None,
    }
}

/// The enum literal or constant with this name in a domain.
pub(crate) fn literal_value(name: &str, domain: DomainId, program: &Program) -> Option<Value> {
    let DomainElements::Atoms { first, count } = program.domains.get(domain.0 as usize)?.elements
    else {
        return None;
    };
    let names = program
        .symbols
        .atoms
        .get(first.0 as usize..(first.0 + count) as usize)?;
    let index = names.iter().position(|known| &**known == name)?;
    Some(Value::Atom(Atom(first.0 + index as u32)))
}

/// Converts a value to a datum; atoms and rules are represented by their names.
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
        // a map with text keys is a record
        Value::Map(pairs) if pairs.keys().all(|key| matches!(key, Value::Text(_))) => {
            let field = |(key, value): (&Value, &Value)| {
                let Value::Text(name) = key else {
                    return None;
                };
                Some((name.to_string(), datum_of(value, naming)))
            };
            Datum::record(pairs.iter().filter_map(field))
        }
        Value::Atom(_) | Value::Rule(_) | Value::Complex(_) | Value::Bag(_) | Value::Map(_) => {
            Datum::text(value.show(naming).to_string())
        }
    }
}
