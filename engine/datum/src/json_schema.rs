//! Converts message schemas to JSON Schema. Each record becomes a definition under its type's name.

use std::collections::BTreeMap;

use serde_json::{Map, Value, json};

use crate::schema::{OutlineKey, Schema, Shape};

/// Collects the definitions of named types.
pub struct SchemaDefinitions {
    /// JSON pointer to the definitions in the document, for example `#/$defs`.
    prefix: &'static str,
    known: BTreeMap<String, Value>,
}

impl SchemaDefinitions {
    /// Creates an empty collection for a document with its definitions at this place, for example `#/$defs`.
    pub fn at(prefix: &'static str) -> Self {
        Self {
            prefix,
            known: BTreeMap::new(),
        }
    }

    /// The JSON Schema of a message schema; a reference if the type has a name.
    pub fn schema(&mut self, schema: &Schema) -> Value {
        match &schema.shape {
            Shape::Any if schema.name.is_empty() => json!({}),
            Shape::Any => json!({ "title": schema.name }),
            Shape::Bool => json!({ "type": "boolean" }),
            Shape::I8 => whole(i8::MIN, i8::MAX),
            Shape::I16 => whole(i16::MIN, i16::MAX),
            Shape::I32 => whole(i32::MIN, i32::MAX),
            Shape::I64 => whole(i64::MIN, i64::MAX),
            Shape::U8 => whole(u8::MIN, u8::MAX),
            Shape::U16 => whole(u16::MIN, u16::MAX),
            Shape::U32 => whole(u32::MIN, u32::MAX),
            Shape::U64 => whole(u64::MIN, u64::MAX),
            Shape::F32 => self.float("float32", "float"),
            Shape::F64 => self.float("float64", "double"),
            Shape::Text => json!({ "type": "string" }),
            Shape::Option(some) => json!({ "anyOf": [self.schema(some), { "type": "null" }] }),
            Shape::List(element) => json!({ "type": "array", "items": self.schema(element) }),
            Shape::Array(element, count) => json!({
                "type": "array", "items": self.schema(element), "minItems": count, "maxItems": count,
            }),
            Shape::Record(fields) if schema.name.is_empty() => self.record(schema, fields),
            Shape::Record(fields) => {
                let key = key(&schema.name);
                if !self.known.contains_key(&key) {
                    let record = self.record(schema, fields);
                    self.known.insert(key.clone(), record);
                }
                self.reference(&key)
            }
        }
    }

    /// The schema of a record. No property is required, because an omitted field has its type's default.
    fn record(&mut self, schema: &Schema, fields: &[OutlineKey]) -> Value {
        let properties: Map<String, Value> = fields
            .iter()
            .map(|field| {
                let mut property = self.schema(&field.schema);
                if !field.doc.is_empty() {
                    property = described(property, &field.doc);
                }
                (field.name.to_string(), property)
            })
            .collect();
        let mut record =
            json!({ "type": "object", "properties": properties, "additionalProperties": false });
        if !schema.name.is_empty() {
            record["title"] = schema.name.as_ref().into();
        }
        record
    }

    /// The schema of a float, including the texts for the three values that JSON lacks.
    fn float(&mut self, name: &str, format: &str) -> Value {
        let definition = json!({ "title": name, "anyOf": [
            { "type": "number", "format": format },
            { "enum": ["NaN", "Infinity", "-Infinity"] },
        ] });
        self.known.entry(name.to_owned()).or_insert(definition);
        self.reference(name)
    }

    fn reference(&self, key: &str) -> Value {
        json!({ "$ref": format!("{}/{key}", self.prefix) })
    }

    /// All definitions, by key.
    pub fn into_value(self) -> Value {
        self.known.into_iter().collect::<Map<_, _>>().into()
    }
}

fn whole(least: impl Into<Value>, greatest: impl Into<Value>) -> Value {
    json!({ "type": "integer", "minimum": least.into(), "maximum": greatest.into() })
}

/// Adds a description, except to a `$ref`, whose siblings are ignored.
fn described(mut schema: Value, doc: &str) -> Value {
    if let Value::Object(members) = &mut schema
        && !members.contains_key("$ref")
    {
        members.insert("description".to_owned(), doc.into());
        return schema;
    }
    json!({ "allOf": [schema], "description": doc })
}

/// A type's name as a key: `nav_msgs.Path` for `nav_msgs/Path`, `f64_5_` for `f64[5]`.
pub fn key(name: &str) -> String {
    name.chars()
        .map(|character| match character {
            '/' => '.',
            '.' | '-' | '_' => character,
            _ if character.is_ascii_alphanumeric() => character,
            _ => '_',
        })
        .collect()
}
