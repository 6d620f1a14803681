//! Converts values between the simple types of XML Schema and the types of properties.

use asmotion_composite::model::Scalar;
use asmotion_composite::tree::{Branch, Node};
use toml_edit::{Array, Formatted, Value};

/// The XML Schema types and their property types. When a property type occurs several times, its first row is written.
const TYPES: &[(&str, Scalar)] = &[
    ("string", Scalar::Text),
    ("boolean", Scalar::Boolean),
    ("byte", Scalar::I8),
    ("short", Scalar::I16),
    ("int", Scalar::I32),
    ("long", Scalar::I64),
    ("integer", Scalar::I64),
    ("unsignedByte", Scalar::U8),
    ("unsignedShort", Scalar::U16),
    ("unsignedInt", Scalar::U32),
    ("unsignedLong", Scalar::U64),
    ("nonNegativeInteger", Scalar::U64),
    ("positiveInteger", Scalar::U64),
    ("float", Scalar::F32),
    ("double", Scalar::F64),
    ("decimal", Scalar::F64),
    ("anyURI", Scalar::Uri),
    // XML Schema has no such types
    ("string", Scalar::Path),
    ("string", Scalar::Secret),
];

/// The property type for a type of XML Schema.
pub(crate) fn scalar(xml: &str) -> Option<Scalar> {
    let found = TYPES.iter().find(|(known, _)| *known == xml);
    found.map(|(_, scalar)| *scalar)
}

/// The type of XML Schema for a property type.
pub(crate) fn xml_type(scalar: Scalar) -> &'static str {
    let found = TYPES.iter().find(|(_, known)| *known == scalar);
    found.map_or("string", |(xml, _)| xml)
}

/// Description of a type's values for messages.
pub(crate) fn expected(scalar: Scalar) -> &'static str {
    match scalar {
        Scalar::Boolean => "`true` or `false`",
        Scalar::I8 | Scalar::I16 | Scalar::I32 | Scalar::I64 => "an integer",
        Scalar::U8 | Scalar::U16 | Scalar::U32 | Scalar::U64 => "a natural number",
        Scalar::F32 | Scalar::F64 => "a number",
        Scalar::Text | Scalar::Uri | Scalar::Path | Scalar::Secret => "a string",
    }
}

/// Converts a text to a value of this type. Returns `None` if it is not valid.
pub(crate) fn typed(text: &str, scalar: Scalar) -> Option<Value> {
    match scalar {
        Scalar::Text | Scalar::Uri | Scalar::Path | Scalar::Secret => Some(verbatim(text)),
        Scalar::Boolean => match text {
            "true" | "1" => Some(true.into()),
            "false" | "0" => Some(false.into()),
            _ => None,
        },
        Scalar::I8 | Scalar::I16 | Scalar::I32 | Scalar::I64 => {
            text.parse::<i64>().ok().map(Value::from)
        }
        Scalar::U8 | Scalar::U16 | Scalar::U32 | Scalar::U64 => {
            let number = text.parse::<i64>().ok()?;
            (number >= 0).then(|| number.into())
        }
        Scalar::F32 | Scalar::F64 => text.parse::<f64>().ok().map(real),
    }
}

/// Converts a text of unknown type: to a Boolean or a number if it looks like one, else to text.
pub(crate) fn guessed(text: &str) -> Value {
    if let Ok(truth) = text.parse::<bool>() {
        return truth.into();
    }
    if let Some(number) = text.parse::<i64>().ok().filter(|it| it.to_string() == text) {
        return number.into();
    }
    match text.parse::<f64>() {
        Ok(number) if format!("{number:?}") == text => real(number),
        Ok(_) | Err(_) => verbatim(text),
    }
}

/// A floating-point value, which TOML writes with `.0` even if it is whole.
fn real(number: f64) -> Value {
    Value::Float(Formatted::new(number))
}

/// A text in which `${` is escaped, unless it is an environment variable.
fn verbatim(text: &str) -> Value {
    if names_variable(text) {
        text.into()
    } else {
        text.replace("${", "$${").into()
    }
}

/// Returns whether a text has the form `${NAME}`.
pub(crate) fn names_variable(text: &str) -> bool {
    let inner = text
        .strip_prefix("${")
        .and_then(|rest| rest.strip_suffix('}'));
    let letters =
        |letter: char| letter.is_ascii_uppercase() || letter.is_ascii_digit() || letter == '_';
    inner.is_some_and(|name| !name.is_empty() && name.chars().all(letters))
}

pub(crate) fn list(values: impl IntoIterator<Item = Value>) -> Value {
    Value::Array(values.into_iter().collect::<Array>())
}

/// The texts of a value or a list of values; `None` for anything else.
pub(crate) fn texts(node: &Node) -> Option<Vec<String>> {
    if let Branch::List(items) = &node.value {
        items.iter().map(text).collect()
    } else {
        text(node).map(|text| vec![text])
    }
}

fn text(node: &Node) -> Option<String> {
    match &node.value {
        Branch::Text(text) | Branch::Date(text) => Some(text.replace("$${", "${")),
        Branch::Integer(number) => Some(number.to_string()),
        Branch::Float(number) => Some(format!("{number:?}")),
        Branch::Boolean(truth) => Some(truth.to_string()),
        Branch::List(_) | Branch::Table(_) => None,
    }
}
