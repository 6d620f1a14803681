//! Types and ranges of properties.

use crate::codes::c015::InvalidSetting;
use crate::codes::c016::SettingOutOfRange;
use asmotion_datum::{Schema, Shape, Word as _};
use asmotion_diagnostics::Span;

use super::admissible::conform;
use crate::finding::Findings;
use crate::model::{Property, PropertyType, Scalar};
use crate::range::Range;
use crate::scope::SubstitutionNotes;
use crate::types::primitive;
use crate::value::SettingValue;

/// Converts a value to the type of a composite property; reports a wrong type or a value out of range.
pub(super) fn accept(
    property: &Property,
    value: SettingValue,
    at: Option<Span>,
    notes: &mut SubstitutionNotes,
) -> Option<SettingValue> {
    let name = &property.name.value;
    let declared = Some(property.kind.span);
    let found = value.describe();
    let Some(value) = of_type(value, property.kind.value) else {
        notes.found(InvalidSetting::WrongType {
            name: name.clone(),
            wanted: describe(property.kind.value),
            found,
            at,
            declared,
        });
        return None;
    };
    let (least, greatest) = limits(property.kind.scalar);
    let range = Range {
        min: property.min.as_ref().map(|min| min.value).or(least),
        max: property.max.as_ref().map(|max| max.value).or(greatest),
        unit: String::new(),
    };
    let limit = property.min.as_ref().or(property.max.as_ref());
    let declared = limit.map(|limit| limit.span).or(declared);
    within(name, &value, &range, at, declared, notes).then_some(value)
}

/// Checks that all numbers of a value are in range.
pub(super) fn within(
    name: &str,
    value: &SettingValue,
    range: &Range,
    at: Option<Span>,
    declared: Option<Span>,
    notes: &mut SubstitutionNotes,
) -> bool {
    if let SettingValue::List(items) = value {
        return items
            .iter()
            .all(|item| within(name, item, range, at, declared, notes));
    }
    match value.number() {
        Some(number) if !range.contains(number) => {
            let (name, value) = (name.to_owned(), value.to_string());
            let range = range.clone();
            notes.found(SettingOutOfRange {
                name,
                value,
                range,
                at,
                declared,
            });
            false
        }
        Some(_) | None => true,
    }
}

/// The shape of one value of a type; addresses, paths and secrets are strings.
fn shape(scalar: Scalar) -> Shape {
    primitive(scalar.word()).map_or(Shape::Text, |schema| schema.shape)
}

/// Describes the values of a type.
fn describe(kind: PropertyType) -> String {
    let shape = shape(kind.scalar);
    let (article, one) = if shape.is_integer() {
        ("an", "integer")
    } else if shape.is_float() {
        ("a", "number")
    } else if shape == Shape::Bool {
        ("a", "Boolean")
    } else {
        ("a", "string")
    };
    if kind.list {
        format!("a list of {one}s")
    } else {
        format!("{article} {one}")
    }
}

/// Numeric limits of a type.
fn limits(scalar: Scalar) -> (Option<f64>, Option<f64>) {
    match scalar {
        Scalar::I8 => (Some(i8::MIN.into()), Some(i8::MAX.into())),
        Scalar::I16 => (Some(i16::MIN.into()), Some(i16::MAX.into())),
        Scalar::I32 => (Some(i32::MIN.into()), Some(i32::MAX.into())),
        Scalar::U8 => (Some(0.0), Some(u8::MAX.into())),
        Scalar::U16 => (Some(0.0), Some(u16::MAX.into())),
        Scalar::U32 => (Some(0.0), Some(u32::MAX.into())),
        Scalar::U64 => (Some(0.0), None),
        Scalar::I64
        | Scalar::F32
        | Scalar::F64
        | Scalar::Text
        | Scalar::Boolean
        | Scalar::Uri
        | Scalar::Path
        | Scalar::Secret => (None, None),
    }
}

/// Converts a value to a type.
fn of_type(value: SettingValue, kind: PropertyType) -> Option<SettingValue> {
    let one = Schema::plain(shape(kind.scalar));
    let schema = if kind.list {
        Schema::many(one, None)
    } else {
        one
    };
    let value = conform(value, &schema)?;
    let is_secret = kind.scalar == Scalar::Secret;
    Some(if is_secret { hidden(value) } else { value })
}

/// Makes every string in a value a secret.
fn hidden(value: SettingValue) -> SettingValue {
    match value {
        SettingValue::Text(text) => SettingValue::Secret(text),
        SettingValue::List(items) => SettingValue::List(items.into_iter().map(hidden).collect()),
        other @ (SettingValue::Integer(_)
        | SettingValue::Real(_)
        | SettingValue::Boolean(_)
        | SettingValue::Secret(_)
        | SettingValue::Record(_)) => other,
    }
}

/// Parses a string given outside the files as a value of this type.
pub(super) fn from_text(text: &str, kind: PropertyType) -> Option<SettingValue> {
    if kind.list {
        if text.trim_start().starts_with('[') {
            return of_type(SettingValue::from_toml(text)?, kind);
        }
        let scalar = PropertyType {
            list: false,
            ..kind
        };
        let items = text.split(',').map(|item| from_text(item.trim(), scalar));
        return items.collect::<Option<_>>().map(SettingValue::List);
    }
    let shape = shape(kind.scalar);
    if shape.is_integer() {
        text.parse().ok().map(SettingValue::Integer)
    } else if shape.is_float() {
        text.parse().ok().map(SettingValue::Real)
    } else if shape == Shape::Bool {
        text.parse().ok().map(SettingValue::Boolean)
    } else {
        of_type(SettingValue::Text(text.to_owned()), kind)
    }
}
