//! Validates values of properties: type, range and permitted values.

use crate::codes::c015::InvalidSetting;
use asmotion_component::declaration::PropertyDeclaration;
use asmotion_datum::{Datum, Schema, Shape};
use asmotion_diagnostics::Span;

use super::kind::within;
use crate::finding::Findings;
use crate::range::Range;
use crate::scope::SubstitutionNotes;
use crate::value::SettingValue;

/// Converts a value to the type of the property; reports an error and returns `None` if the property does not accept
/// it.
pub fn lawful(
    declared: &PropertyDeclaration,
    value: SettingValue,
    at: Option<Span>,
    notes: &mut SubstitutionNotes,
) -> Option<SettingValue> {
    let name = declared.name.clone();
    let found = value.describe();
    let Some(value) = conform(value, &declared.schema) else {
        notes.found(InvalidSetting::WrongType {
            name,
            wanted: format!("a value of type `{}`", declared.schema),
            found,
            at,
            declared: None,
        });
        return None;
    };
    if let Some((least, greatest)) = &declared.range {
        let (min, max) = (least.as_float(), greatest.as_float());
        let range = Range {
            min,
            max,
            unit: declared.unit.clone(),
        };
        if !within(&name, &value, &range, at, None, notes) {
            return None;
        }
    }
    if declared.choices.is_empty() || declared.choices.contains(&value.datum()) {
        return converts(declared, &value, at, notes).then_some(value);
    }
    let choices: Vec<String> = declared.choices.iter().map(Datum::to_string).collect();
    let (value, choices) = (value.to_string(), choices.join(", "));
    notes.found(InvalidSetting::NoChoice {
        name,
        value,
        choices,
        at,
    });
    None
}

/// Returns whether the type of the property accepts the value; otherwise reports the reason.
fn converts(
    declared: &PropertyDeclaration,
    value: &SettingValue,
    at: Option<Span>,
    notes: &mut SubstitutionNotes,
) -> bool {
    let result = declared.conversion.check(&value.datum());
    result
        .map_err(|error| {
            notes.found(InvalidSetting::Refused {
                name: declared.name.clone(),
                reason: error.to_string(),
                at,
            });
        })
        .is_ok()
}

/// Converts a value to the type of `schema`; an integer becomes a float if a float is required.
pub(super) fn conform(value: SettingValue, schema: &Schema) -> Option<SettingValue> {
    let each = |items: Vec<SettingValue>, item: &Schema| {
        let items = items.into_iter().map(|value| conform(value, item));
        items.collect::<Option<_>>().map(SettingValue::List)
    };
    match (&schema.shape, value) {
        (Shape::F32 | Shape::F64, SettingValue::Integer(number)) => {
            Some(SettingValue::Real(number as f64))
        }
        (Shape::Any, value)
        | (Shape::Bool, value @ SettingValue::Boolean(_))
        | (Shape::F32 | Shape::F64, value @ SettingValue::Real(_))
        | (Shape::Text, value @ (SettingValue::Text(_) | SettingValue::Secret(_))) => Some(value),
        (shape, value @ SettingValue::Integer(_)) if shape.is_integer() => Some(value),
        (Shape::Option(inner), value) => conform(value, inner),
        (Shape::List(item), SettingValue::List(items)) => each(items, item),
        (Shape::Array(item, count), SettingValue::List(items)) if items.len() == *count => {
            each(items, item)
        }
        (Shape::Record(fields), SettingValue::Record(values)) => {
            let values = values.into_iter().map(|(name, value)| {
                let field = fields.iter().find(|field| field.name == name.as_str())?;
                Some((name, conform(value, &field.schema)?))
            });
            values.collect::<Option<_>>().map(SettingValue::Record)
        }
        (_, _) => None,
    }
}
