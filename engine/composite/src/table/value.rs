//! Values other than tables: strings, numbers and arbitrary TOML values.

use serde_json::{Value as Json, json};

use super::keys::Reader;
use super::{Key, Many, Value};
use crate::at::At;
use crate::codes::c008::UnknownSchema;
use crate::finding::Findings;
use crate::tree::{Branch, Node};

impl<T: Value> Value for At<T> {
    const MANY: Many = T::MANY;

    fn schema(key: &Key) -> Json {
        T::schema(key)
    }

    fn read(reader: &mut Reader<'_>, key: &At<String>, spec: &Key, node: &Node) -> Option<Self> {
        T::read(reader, key, spec, node).map(|value| Self::new(value, node.span))
    }
}

impl Value for String {
    fn schema(_: &Key) -> Json {
        json!({ "type": "string" })
    }

    fn read(reader: &mut Reader<'_>, key: &At<String>, spec: &Key, node: &Node) -> Option<Self> {
        reader.text(key, node, spec.example).map(|text| text.value)
    }
}

impl Value for bool {
    fn schema(_: &Key) -> Json {
        json!({ "type": "boolean" })
    }

    fn read(reader: &mut Reader<'_>, key: &At<String>, _: &Key, node: &Node) -> Option<Self> {
        if let Branch::Boolean(truth) = node.value {
            Some(truth)
        } else {
            reader.wrong_type(key, "a Boolean", node, "true");
            None
        }
    }
}

impl Value for u64 {
    const MANY: Many = Many::List("a list of integers");

    fn schema(key: &Key) -> Json {
        json!({ "type": "integer", "minimum": key.least as i64, "maximum": key.greatest as i64 })
    }

    fn read(reader: &mut Reader<'_>, key: &At<String>, spec: &Key, node: &Node) -> Option<Self> {
        let Branch::Integer(number) = node.value else {
            let fits = |number: &i64| (spec.least..=spec.greatest).contains(&(*number as f64));
            let meant = if let Branch::Text(text) = &node.value {
                text.parse().ok().filter(fits)
            } else {
                None
            };
            let example = meant.unwrap_or(spec.least.max(1.0) as i64);
            reader.no_integer(key, spec, node, example);
            return None;
        };
        reader.within(key, spec, number as f64, node)?;
        Self::try_from(number).ok()
    }
}

impl Value for f64 {
    fn schema(key: &Key) -> Json {
        let mut schema = json!({ "type": "number" });
        for (bound, limit) in [("minimum", key.least), ("maximum", key.greatest)] {
            if limit.is_finite() {
                schema[bound] = limit.into();
            }
        }
        schema
    }

    fn read(reader: &mut Reader<'_>, key: &At<String>, spec: &Key, node: &Node) -> Option<Self> {
        let number = match node.value {
            Branch::Integer(number) => number as Self,
            Branch::Float(number) => number,
            Branch::Text(_)
            | Branch::Boolean(_)
            | Branch::Date(_)
            | Branch::List(_)
            | Branch::Table(_) => {
                reader.wrong_type(key, "a number", node, &spec.least.to_string());
                return None;
            }
        };
        reader.within(key, spec, number, node)
    }
}

/// A value in a table of names, such as a property that a component sets.
#[derive(Clone, Debug)]
pub struct NamedValue<T> {
    /// Name, which is the key in the table.
    pub name: At<String>,
    /// Value; strings may contain substitutions if it is a [`Node`].
    pub value: T,
}

impl<T: Value> Value for NamedValue<T> {
    const MANY: Many = Many::Names;

    fn schema(key: &Key) -> Json {
        T::schema(key)
    }

    fn read(reader: &mut Reader<'_>, name: &At<String>, spec: &Key, node: &Node) -> Option<Self> {
        // the example of the key is a whole table
        let one = Key {
            example: "\"text\"",
            ..*spec
        };
        let value = T::read(reader, name, &one, node)?;
        Some(Self {
            name: name.clone(),
            value,
        })
    }
}

/// Reads any TOML value; strings may contain substitutions.
impl Value for Node {
    fn schema(_: &Key) -> Json {
        json!({})
    }

    fn read(reader: &mut Reader<'_>, key: &At<String>, _: &Key, node: &Node) -> Option<Self> {
        templates(reader, key, node);
        Some(node.clone())
    }
}

/// Dialect identifier of a file; must equal the example of its key.
#[derive(Clone, Copy, Debug, Default)]
pub struct Dialect;

impl Value for Dialect {
    fn schema(key: &Key) -> Json {
        json!({ "enum": [key.example.trim_matches('"')] })
    }

    fn read(reader: &mut Reader<'_>, key: &At<String>, spec: &Key, node: &Node) -> Option<Self> {
        let wanted = spec.example.trim_matches('"');
        let found = reader.text(key, node, spec.example)?;
        if found.value != wanted {
            let (found, at) = (found.value, found.span);
            reader.report.found(UnknownSchema { found, wanted, at });
        }
        Some(Self)
    }
}

/// Reports the malformed substitutions in a value.
pub(crate) fn templates(reader: &mut Reader<'_>, key: &str, node: &Node) {
    match &node.value {
        Branch::Text(_) => {
            reader.template(key, node, "\"text\"");
        }
        Branch::List(items) => items.iter().for_each(|item| templates(reader, key, item)),
        Branch::Table(table) => {
            let entries = table.entries.iter();
            entries.for_each(|entry| templates(reader, key, &entry.node));
        }
        Branch::Integer(_) | Branch::Float(_) | Branch::Boolean(_) | Branch::Date(_) => {}
    }
}
