//! The dialect as JSON Schema, for editors: what the reader asks for is what may be written, so the two
//! can never disagree.

use serde_json::{Map, Value as Json, json};

use crate::read;
use crate::read::outline::{Asked, Field, Fields, Way};
use crate::value::Value;

/// The schema of composite files.
pub fn composite() -> Json {
    document(
        "a composite of asmotion",
        include_str!("schema.toml"),
        false,
    )
}

/// The schema of files of message types.
pub fn types() -> Json {
    let one = "schema = \"composite-types/1\"\n[type.a]\nfields = { b = \"f64\" }";
    document("message types of asmotion", one, true)
}

/// The schema of files like this one, which has one of everything.
fn document(title: &str, everything: &str, types: bool) -> Json {
    let mut schema = asked(&read::outline(everything, types));
    if let Some(schema) = schema.as_object_mut() {
        schema.insert(
            "$schema".to_owned(),
            "http://json-schema.org/draft-07/schema#".into(),
        );
        schema.insert("title".to_owned(), title.into());
    }
    schema
}

fn asked(asked: &Asked) -> Json {
    if asked.ways.contains(&Way::Any) {
        return json!({});
    }
    match asked.ways.as_slice() {
        [] => json!({}),
        [way] => self::way(way),
        ways => json!({ "anyOf": ways.iter().map(way).collect::<Vec<_>>() }),
    }
}

fn way(way: &Way) -> Json {
    match way {
        Way::Any => json!({}),
        Way::Text => json!({ "type": "string" }),
        Way::Substituted => json!({ "type": "string", "pattern": "\\$\\{" }),
        Way::Flag => json!({ "type": "boolean" }),
        Way::Whole(least, greatest) => {
            json!({ "type": "integer", "minimum": least, "maximum": greatest })
        }
        Way::Real(least, greatest) => real(*least, *greatest),
        Way::Word(words) => json!({ "enum": words }),
        Way::List(item) => json!({ "type": "array", "items": asked(item) }),
        Way::Names(item) => json!({ "type": "object", "additionalProperties": asked(item) }),
        Way::Table(fields) => table(fields),
    }
}

fn real(least: f64, greatest: f64) -> Json {
    let mut schema = json!({ "type": "number" });
    for (key, bound) in [("minimum", least), ("maximum", greatest)] {
        if bound.is_finite() {
            schema[key] = bound.into();
        }
    }
    schema
}

fn table(fields: &Fields) -> Json {
    let properties = fields.keys.iter();
    let properties = properties.map(|(key, field)| ((*key).to_owned(), property(field)));
    let mut schema = json!({
        "type": "object",
        "description": fields.of,
        "properties": properties.collect::<Map<_, _>>(),
        "additionalProperties": false,
    });
    let needed = fields.keys.iter().filter(|(_, field)| field.needed);
    let needed: Vec<_> = needed.map(|(key, _)| *key).collect();
    if !needed.is_empty() {
        schema["required"] = needed.into();
    }
    if !fields.one_of.is_empty() {
        let one = fields.one_of.iter();
        schema["oneOf"] = one.map(|key| json!({ "required": [key] })).collect();
    }
    let depending = fields.keys.iter();
    let depending = depending.filter(|(key, _)| !fields.one_of.contains(key));
    let depending = depending.filter_map(|(key, field)| {
        let on = fields.depends(field)?;
        Some(((*key).to_owned(), json!([on])))
    });
    let depending: Map<_, _> = depending.collect();
    if !depending.is_empty() {
        schema["dependencies"] = depending.into();
    }
    schema
}

fn property(field: &Field) -> Json {
    let mut schema = asked(&field.asked);
    let example = field.example.as_deref().and_then(Value::from_toml);
    let example = example.and_then(|example| serde_json::to_value(example).ok());
    if let (Some(schema), Some(example)) = (schema.as_object_mut(), example) {
        schema.insert("examples".to_owned(), json!([example]));
    }
    schema
}
