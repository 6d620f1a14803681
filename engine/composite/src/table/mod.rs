//! Declarative tables of the dialect: keys with documentation, a reader, a JSON Schema, and a resolved form without
//! source locations.
//!
//! `#[derive(Table)]` generates the implementations; only values that are not tables implement the traits by hand.

mod keys;
pub(crate) mod name;
mod resolve;
#[cfg(test)]
mod tests;
mod value;
mod write;

use std::sync::Arc;

use serde_json::{Map, Value as Json, json};
use toml_edit::Value as Toml;

/// Items named by the generated code, collected in one module.
pub(crate) mod derived {
    pub(crate) use super::keys::{Keys, Reader};
    pub(crate) use super::name;
    pub(crate) use crate::at::At;
    pub(crate) use crate::tree::{Branch, Node, Table as Tree};
}

use self::keys::{Keys, Reader};
pub use self::resolve::{Resolve, Resolver};
pub use self::value::NamedValue;
pub(crate) use self::value::{Dialect, templates};
pub use self::write::{
    Lines, Written, WrittenTable, list, named, one_or_many, present, table, tables, tables_of, toml,
};
use crate::at::At;
use crate::tree::Node;
use crate::value::SettingValue as Plain;

/// A key of a table.
pub struct Key {
    /// Name as written in the file.
    pub name: &'static str,
    /// Documentation of the field.
    pub doc: &'static str,
    /// Example value in TOML syntax; empty if none.
    pub example: &'static str,
    /// Unit of a number; empty if none.
    pub unit: &'static str,
    /// Whether the key is required.
    pub needed: bool,
    /// Minimum of a number.
    pub least: f64,
    /// Maximum of a number.
    pub greatest: f64,
    /// Only key under which the table permits it; empty if always permitted.
    pub within: &'static str,
    /// Default value.
    pub(crate) default: Option<fn() -> Option<Toml>>,
    /// Notation of several values; `None` if only one is permitted.
    pub(crate) many: Option<Many>,
    /// JSON Schema of a single value.
    pub(crate) schema: fn(&Self) -> Json,
    /// Outline of a table value.
    pub(crate) table: fn(&Self) -> Option<Outline>,
}

/// Notation of several values.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Many {
    /// A single value or a list.
    OneOrList,
    /// Always a list.
    List(&'static str),
    /// A list of tables.
    Tables,
    /// A table with names as keys.
    Names,
}

/// The type of the value of a key.
pub(crate) trait Value: Sized {
    /// Notation of several values.
    const MANY: Many = Many::OneOrList;

    /// Returns the JSON Schema of a value.
    fn schema(key: &Key) -> Json;

    /// Returns the outline if the value is a table.
    fn table(_: &Key) -> Option<Outline> {
        None
    }

    /// Reads a value; reports errors and returns `None`.
    fn read(reader: &mut Reader<'_>, key: &At<String>, spec: &Key, node: &Node) -> Option<Self>;
}

/// A value that is a table.
pub(crate) trait Table: Sized {
    /// Returns the keys of the table.
    fn outline() -> Outline;

    /// Returns the first key.
    fn first() -> &'static Key {
        let outline = Self::outline();
        outline.keys.first().map_or(&Key::NAME, |(key, _)| key)
    }

    /// Reads the table key by key; `name` is the key of an entry in a table of names.
    fn read_keys(keys: &mut Keys<'_, '_, '_>, name: &At<String>) -> Option<Self>;
}

/// A value that instances share if their table has no variable.
impl<T: Value + Send + Sync + 'static> Value for Arc<T> {
    const MANY: Many = T::MANY;

    fn schema(key: &Key) -> Json {
        T::schema(key)
    }

    fn table(key: &Key) -> Option<Outline> {
        T::table(key)
    }

    fn read(reader: &mut Reader<'_>, key: &At<String>, spec: &Key, node: &Node) -> Option<Self> {
        reader.shared(key, spec, node)
    }
}

impl<T: Table> Table for Box<T> {
    fn outline() -> Outline {
        T::outline()
    }

    fn read_keys(keys: &mut Keys<'_, '_, '_>, name: &At<String>) -> Option<Self> {
        T::read_keys(keys, name).map(Self::new)
    }
}

/// Description of a table.
#[derive(Clone)]
pub struct Outline {
    /// Noun phrase for messages, such as "a wire".
    pub of: &'static str,
    /// Documentation of the type.
    pub doc: &'static str,
    /// Keys in declaration order, each with the key it depends on, if any.
    pub keys: Vec<(&'static Key, Option<&'static str>)>,
    /// Keys of which exactly one is required.
    pub one_of: Vec<&'static str>,
    /// `true` if the keys of a table can be names that the composite chooses instead, such as the literals of an out function.
    pub has_names: bool,
}

impl Key {
    /// Pseudo-key for the name of an entry.
    pub(crate) const NAME: Self = Self {
        name: "",
        doc: "",
        example: "",
        unit: "",
        needed: false,
        least: f64::NEG_INFINITY,
        greatest: f64::INFINITY,
        within: "",
        default: None,
        many: None,
        schema: |_| json!({}),
        table: |_| None,
    };

    /// Returns the default value in TOML syntax.
    pub(crate) fn default_text(&self) -> Option<String> {
        let default = self.default?()?;
        Some(default.to_string().trim().to_owned())
    }

    /// Returns the JSON Schema of the value, with documentation, unit and default.
    pub(crate) fn property(&self) -> Json {
        let one = (self.schema)(self);
        let mut schema = match self.many {
            None => one,
            Some(Many::OneOrList) => {
                let list = json!({ "type": "array", "items": one });
                json!({ "anyOf": [one, list] })
            }
            Some(Many::List(_) | Many::Tables) => json!({ "type": "array", "items": one }),
            Some(Many::Names) => json!({ "type": "object", "additionalProperties": one }),
        };
        let Some(shown) = schema.as_object_mut() else {
            return schema;
        };
        let mut doc = self.doc.to_owned();
        if !self.unit.is_empty() {
            doc.push_str(&format!(" In {}.", self.unit));
        }
        let words = shown.remove("$comment");
        if let Some(words) = words.as_ref().and_then(Json::as_str) {
            doc.push_str("\n\n");
            doc.push_str(words);
        }
        shown.insert("description".to_owned(), doc.trim().into());
        for (key, text) in [
            ("default", self.default_text()),
            ("example", Some(self.example.to_owned())),
        ] {
            let value = text.and_then(|text| Plain::from_toml(&text));
            let Some(value) = value.and_then(|value| serde_json::to_value(value).ok()) else {
                continue;
            };
            match key {
                "default" => shown.insert("default".to_owned(), value),
                _ => shown.insert("examples".to_owned(), json!([value])),
            };
        }
        schema
    }
}

impl Outline {
    pub(crate) fn new(of: &'static str, doc: &'static str) -> Self {
        Self {
            of,
            doc,
            keys: Vec::new(),
            one_of: Vec::new(),
            has_names: false,
        }
    }

    pub(crate) fn add(&mut self, key: &'static Key) {
        self.keys.push((key, None));
    }

    pub(crate) fn all(self) -> Vec<&'static Key> {
        self.keys.into_iter().map(|(key, _)| key).collect()
    }

    /// Appends the keys of a flattened field.
    pub(crate) fn append(&mut self, part: Self) {
        self.keys.extend(part.keys);
        self.one_of.extend(part.one_of);
    }

    /// Appends the keys of a variant, which is selected by the first of them.
    pub(crate) fn choice(&mut self, keys: Vec<&'static Key>) {
        let first = keys.first().map(|key| key.name);
        self.one_of.extend(first);
        let with = |key: &&Key| first.filter(|first| *first != key.name);
        self.keys
            .extend(keys.into_iter().map(|key| (key, with(&key))));
    }

    /// Retains the keys permitted if the table is the value of `key`.
    pub(crate) fn within(mut self, key: &str) -> Self {
        self.keys
            .retain(|(it, _)| it.within.is_empty() || it.within == key);
        self
    }

    /// Returns the JSON Schema of the table.
    pub(crate) fn schema(&self) -> Json {
        let properties = self.keys.iter();
        let properties: Map<_, _> = properties
            .map(|(key, _)| (key.name.to_owned(), key.property()))
            .collect();
        let mut schema = json!({
            "type": "object",
            "description": self.doc,
            "properties": properties,
            "additionalProperties": false,
        });
        let needed = self.keys.iter().filter_map(|(key, with)| {
            let alone = with.is_none() && !self.one_of.contains(&key.name);
            (key.needed && alone).then_some(key.name)
        });
        let needed: Vec<_> = needed.collect();
        if !needed.is_empty() {
            schema["required"] = needed.into();
        }
        if !self.one_of.is_empty() {
            let one = self.one_of.iter();
            schema["oneOf"] = one.map(|key| json!({ "required": [key] })).collect();
        }
        let mut depending: Map<String, Json> = Map::new();
        for (key, with) in &self.keys {
            let Some(with) = *with else { continue };
            depending.insert(key.name.to_owned(), json!([with]));
            if key.needed {
                let list = depending.entry(with).or_insert_with(|| json!([]));
                if let Some(list) = list.as_array_mut() {
                    list.push(key.name.into());
                }
            }
        }
        if !depending.is_empty() {
            schema["dependencies"] = depending.into();
        }
        schema
    }
}

/// Returns the schema of a table that may be abbreviated to the value of the key `short`.
pub(crate) fn or_short(schema: Json, outline: Outline, short: &str) -> Json {
    let mut keys = outline.keys.iter();
    match keys.find(|(key, _)| key.name == short) {
        Some((key, _)) => json!({ "anyOf": [key.property(), schema] }),
        None => schema,
    }
}
