//! Values as text.

use crate::argument::unary;
use crate::builtin::BuiltinBody;
use asmotion_value::{Value, ValueNames};

/// Converts a value to a string: as displayed, but strings and characters without quotes.
pub fn to_string(value: &Value, names: &dyn ValueNames) -> String {
    match value {
        Value::Text(text) => text.as_ref().clone(),
        Value::Char(character) => character.to_string(),
        Value::Real(number) => real_text(number.get()),
        Value::Undef
        | Value::Bool(_)
        | Value::Int(_)
        | Value::Atom(_)
        | Value::Rule(_)
        | Value::Complex(_)
        | Value::Tuple(_)
        | Value::Seq(_)
        | Value::Set(_)
        | Value::Bag(_)
        | Value::Map(_) => value.show(names).to_string(),
    }
}

/// The body of every `toString` in the library.
pub(crate) const TO_STRING: BuiltinBody =
    |arguments, context| unary(arguments, |value: &Value| to_string(value, context.names));

/// Formats a number as the reference does: with an exponent below 10⁻³ and from 10⁷ on.
pub fn real_text(number: f64) -> String {
    let size = number.abs();
    if number.is_nan() {
        "NaN".to_owned()
    } else if size.is_infinite() {
        let sign = if number < 0.0 { "-" } else { "" };
        format!("{sign}Infinity")
    } else if size == 0.0 || (1e-3..1e7).contains(&size) {
        format!("{number:?}")
    } else {
        let text = format!("{number:E}");
        match text.split_once('E') {
            Some((digits, exponent)) if !digits.contains('.') => format!("{digits}.0E{exponent}"),
            _ => text,
        }
    }
}
