//! Values that are not tables: strings, numbers, words and ends.

use asmotion_component::{Lock, OnDeadline, OnException, OnStale, Overrun, Scheduler, Sharing};
use asmotion_coordinator::{PublishWhen, Receive};
use asmotion_datum::{Codec, Word};
use serde_json::{Value as Json, json};
use toml_edit::Value as Toml;

use super::{Key, Many, Resolve, Resolver, Value, Written};
use crate::at::At;
use crate::codes::c008::UnknownSchema;
use crate::finding::Findings;
use crate::model::{
    Address, Amount, BridgeKind, BuiltinComponent, Busy, Cancel, Condition, ConnectionType,
    Delivery, Direction, End, MessagePath, Outage, PropertyType, ProxyMode, RestartPolicy, Scalar,
    Template, Terminal, Tls, Transport,
};
use crate::nearest::nearest_name;
use crate::read::keys::Reader;
use crate::read::{name, setting};
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

/// Implements `Value` for types written as strings.
macro_rules! texts {
    ($($kind:ty: |$reader:ident, $text:ident| $read:expr;)*) => {
        $(impl Value for $kind {
            fn schema(_: &Key) -> Json {
                json!({ "type": "string" })
            }

            fn read(
                $reader: &mut Reader<'_>,
                key: &At<String>,
                spec: &Key,
                node: &Node,
            ) -> Option<Self> {
                let $text = $reader.text(key, node, spec.example)?;
                $read
            }
        })*
    };
}

texts! {
    String: |reader, text| Some(text.value);
    End: |reader, text| name::end(reader, &text);
    Terminal: |reader, text| name::terminal(reader, &text);
    MessagePath: |reader, text| name::path(reader, &text);
    Condition: |reader, text| Some(name::condition(reader, text));
}

/// Implements `Value` for enumerations of words.
macro_rules! words {
    ($($kind:ident)*) => {
        $(impl Value for $kind {
            fn schema(_: &Key) -> Json {
                words::<$kind>()
            }

            fn read(reader: &mut Reader<'_>, key: &At<String>, spec: &Key, node: &Node) -> Option<Self> {
                reader.word(key, spec, node)
            }
        }

        impl Resolve for $kind {
            type Resolved = Self;

            fn resolve(&self, _: &Key, _: &mut Resolver<'_>) -> Option<Self> {
                Some(*self)
            }
        }

        impl Written for $kind {
            fn toml(&self) -> Option<Toml> {
                Some(self.word().into())
            }
        })*
    };
}

words! {
    BridgeKind BuiltinComponent Busy Cancel Codec Delivery Direction ConnectionType Lock OnDeadline OnException OnStale Outage Overrun
    ProxyMode PublishWhen Receive RestartPolicy Scheduler Sharing Tls Transport
}

/// Returns the JSON Schema of a set of words with their documentation.
fn words<W: Word>() -> Json {
    let meanings = W::WORDS.iter();
    let meanings = meanings.map(|(word, _, doc)| format!("- `{word}`: {doc}"));
    let meanings: Vec<String> = meanings.collect();
    json!({ "enum": W::words(), "$comment": meanings.join("\n") })
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
            reader.wrong_type(key, "an integer", node, &example.to_string());
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

impl Value for Template {
    fn schema(_: &Key) -> Json {
        json!({ "type": "string" })
    }

    fn read(reader: &mut Reader<'_>, key: &At<String>, spec: &Key, node: &Node) -> Option<Self> {
        reader.template(key, node, spec.example)
    }
}

impl Value for Address {
    fn schema(key: &Key) -> Json {
        Template::schema(key)
    }

    fn read(reader: &mut Reader<'_>, key: &At<String>, spec: &Key, node: &Node) -> Option<Self> {
        reader.template(key, node, spec.example).map(Self)
    }
}

/// Reads an integer or a substitution.
impl Value for Amount {
    fn schema(key: &Key) -> Json {
        json!({ "anyOf": [u64::schema(key), { "type": "string", "pattern": "\\$\\{" }] })
    }

    fn read(reader: &mut Reader<'_>, key: &At<String>, spec: &Key, node: &Node) -> Option<Self> {
        if let Branch::Text(text) = &node.value
            && text.contains("${")
        {
            reader.template(key, node, "50").map(Self::Template)
        } else {
            u64::read(reader, key, spec, node).map(Self::Number)
        }
    }
}

/// Reads any TOML value; strings may contain substitutions.
impl Value for Node {
    fn schema(_: &Key) -> Json {
        json!({})
    }

    fn read(reader: &mut Reader<'_>, key: &At<String>, _: &Key, node: &Node) -> Option<Self> {
        setting::templates(reader, key, node);
        Some(node.clone())
    }
}

/// Reads a property type such as `f64` or `string[]`.
impl Value for PropertyType {
    fn schema(_: &Key) -> Json {
        let one = Scalar::words().into_iter().map(str::to_owned);
        let many = Scalar::words().into_iter().map(|word| format!("{word}[]"));
        json!({ "enum": one.chain(many).collect::<Vec<_>>() })
    }

    fn read(reader: &mut Reader<'_>, key: &At<String>, spec: &Key, node: &Node) -> Option<Self> {
        let word = reader.text(key, node, spec.example)?;
        let (scalar, list) = match word.strip_suffix("[]") {
            Some(scalar) => (scalar, true),
            None => (word.as_str(), false),
        };
        let found = Scalar::of_word(scalar);
        if found.is_none() {
            let nearest = nearest_name(scalar, Scalar::words());
            reader.unknown_word(key, &word, Scalar::words(), nearest);
        }
        found.map(|scalar| Self { scalar, list })
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
