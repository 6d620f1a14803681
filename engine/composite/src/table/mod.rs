//! What every table of the dialect has: keys with their documentation, a reader, a schema, and the same table without places.
//!
//! `#[derive(Table)]` writes the implementations; by hand are those of the few values that are no tables.

mod resolve;
#[cfg(test)]
mod tests;
mod value;
mod write;

use serde_json::{Map, Value as Json, json};
use toml_edit::Value as Toml;

/// What the derive names, so that it needs no other module.
pub(crate) mod derived {
    pub(crate) use crate::at::At;
    pub(crate) use crate::read::keys::{Keys, Reader};
    pub(crate) use crate::read::name;
    pub(crate) use crate::tree::{Branch, Node, Table as Tree};
}

pub use self::resolve::{Resolve, Resolver};
pub(crate) use self::value::Dialect;
pub use self::write::{
    Lines, Written, WrittenTable, constant, list, one_or_many, table, tables, tables_of, toml,
};
use crate::at::At;
use crate::read::keys::{Keys, Reader};
use crate::tree::Node;
use crate::value::SettingValue as Plain;

/// A key of a table, as its declaration says it.
pub struct Key {
    /// As it is written.
    pub name: &'static str,
    /// The documentation of its field.
    pub doc: &'static str,
    /// A value as TOML writes it; empty for none.
    pub example: &'static str,
    /// Of a number; empty for none.
    pub unit: &'static str,
    /// Whether it must be there.
    pub needed: bool,
    /// The least number.
    pub least: f64,
    /// The greatest number.
    pub greatest: f64,
    /// The only key under which a table has it; empty where all have it.
    pub within: &'static str,
    /// What holds where it is left out.
    pub(crate) default: Option<fn() -> Option<Toml>>,
    /// How several are written, where there may be several.
    pub(crate) many: Option<Many>,
    /// How one value is written.
    pub(crate) schema: fn(&Self) -> Json,
    /// The table that it has as its value.
    pub(crate) table: fn(&Self) -> Option<Outline>,
}

/// How several values are written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Many {
    /// As one of them, or as a list.
    OneOrList,
    /// As a list, whatever it has.
    List(&'static str),
    /// As a list of tables.
    Tables,
    /// As a table, by name.
    Names,
}

/// What a key can have as its value.
pub(crate) trait Value: Sized {
    /// How several are written.
    const MANY: Many = Many::OneOrList;

    /// How one is written, as JSON Schema.
    fn schema(key: &Key) -> Json;

    /// The table that it is, if it is one.
    fn table(_: &Key) -> Option<Outline> {
        None
    }

    /// Reads one, and reports what is wrong.
    fn read(reader: &mut Reader<'_>, key: &At<String>, spec: &Key, node: &Node) -> Option<Self>;
}

/// A value that is a table.
pub(crate) trait Table: Sized {
    /// Its keys.
    fn outline() -> Outline;

    /// The first of them.
    fn first() -> &'static Key {
        let outline = Self::outline();
        outline.keys.first().map_or(&Key::NAME, |(key, _)| key)
    }

    /// Reads it key by key; `name` is its name where it is an entry of a table of names.
    fn read_keys(keys: &mut Keys<'_, '_, '_>, name: &At<String>) -> Option<Self>;
}

impl<T: Table> Table for Box<T> {
    fn outline() -> Outline {
        T::outline()
    }

    fn read_keys(keys: &mut Keys<'_, '_, '_>, name: &At<String>) -> Option<Self> {
        T::read_keys(keys, name).map(Self::new)
    }
}

/// A table as its declaration says it.
#[derive(Clone)]
pub struct Outline {
    /// What it is, as in "a wire".
    pub of: &'static str,
    /// Its documentation.
    pub doc: &'static str,
    /// Its keys in the order of declaration, each with the key without which it is unknown, if there is one.
    pub keys: Vec<(&'static Key, Option<&'static str>)>,
    /// Of these keys there is exactly one.
    pub one_of: Vec<&'static str>,
}

impl Key {
    /// The name of an entry, which is no key.
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

    /// What holds where it is left out, as TOML.
    pub(crate) fn default_text(&self) -> Option<String> {
        let default = self.default?()?;
        Some(default.to_string().trim().to_owned())
    }

    /// How its value is written, with everything an editor can show.
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
        }
    }

    pub(crate) fn add(&mut self, key: &'static Key) {
        self.keys.push((key, None));
    }

    pub(crate) fn all(self) -> Vec<&'static Key> {
        self.keys.into_iter().map(|(key, _)| key).collect()
    }

    /// Adds the keys of a part.
    pub(crate) fn append(&mut self, part: Self) {
        self.keys.extend(part.keys);
        self.one_of.extend(part.one_of);
    }

    /// Adds the keys of a variant, which the first of them chooses.
    pub(crate) fn choice(&mut self, keys: Vec<&'static Key>) {
        let first = keys.first().map(|key| key.name);
        self.one_of.extend(first);
        let with = |key: &&Key| first.filter(|first| *first != key.name);
        self.keys
            .extend(keys.into_iter().map(|key| (key, with(&key))));
    }

    /// The keys it has as the value of a key.
    pub(crate) fn within(mut self, key: &str) -> Self {
        self.keys
            .retain(|(it, _)| it.within.is_empty() || it.within == key);
        self
    }

    /// The table as JSON Schema.
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

/// The schema of a table that may be written as the value of one of its keys.
pub(crate) fn or_short(schema: Json, outline: Outline, short: &str) -> Json {
    let mut keys = outline.keys.iter();
    match keys.find(|(key, _)| key.name == short) {
        Some((key, _)) => json!({ "anyOf": [key.property(), schema] }),
        None => schema,
    }
}
