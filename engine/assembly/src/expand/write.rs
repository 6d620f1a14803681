//! Keys and values of TOML, one after the other.

use std::fmt::Display;

use toml_edit::{Array, ArrayOfTables, InlineTable, Item, Key, Table, Value as Toml};

use crate::value::{REDACTED, Value};

/// The keys of a table, in the order in which they are written.
#[derive(Default)]
pub(super) struct Keys(Vec<(String, Toml)>);

impl Keys {
    pub(super) fn new() -> Self {
        Self::default()
    }

    pub(super) fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    pub(super) fn put(&mut self, key: &str, value: impl Into<Toml>) {
        self.0.push((key.to_owned(), value.into()));
    }

    pub(super) fn text(&mut self, key: &str, text: &str) {
        self.put(key, text);
    }

    /// A text, if there is one.
    pub(super) fn texts<T: AsRef<str>>(&mut self, key: &str, text: impl IntoIterator<Item = T>) {
        for text in text {
            self.text(key, text.as_ref());
        }
    }

    pub(super) fn word(&mut self, key: &str, word: impl Display) {
        self.put(key, word.to_string());
    }

    pub(super) fn words(&mut self, key: &str, word: Option<impl Display>) {
        if let Some(word) = word {
            self.word(key, word);
        }
    }

    pub(super) fn flag(&mut self, key: &str, truth: bool) {
        self.put(key, truth);
    }

    pub(super) fn flags(&mut self, key: &str, truth: Option<bool>) {
        if let Some(truth) = truth {
            self.flag(key, truth);
        }
    }

    /// A number; none that is read from a file is too large for TOML.
    pub(super) fn whole(&mut self, key: &str, number: u64) {
        self.put(key, i64::try_from(number).unwrap_or(i64::MAX));
    }

    pub(super) fn wholes(&mut self, key: &str, number: Option<u64>) {
        if let Some(number) = number {
            self.whole(key, number);
        }
    }

    pub(super) fn real(&mut self, key: &str, number: f64) {
        self.put(key, number);
    }

    /// A list of numbers, unless it is empty.
    pub(super) fn numbers(&mut self, key: &str, numbers: &[u64]) {
        let numbers = numbers
            .iter()
            .map(|number| i64::try_from(*number).unwrap_or(i64::MAX));
        let list: Array = numbers.collect();
        if !list.is_empty() {
            self.put(key, list);
        }
    }

    /// A list of texts, unless it is empty.
    pub(super) fn list(&mut self, key: &str, texts: impl IntoIterator<Item = String>) {
        let list: Array = texts.into_iter().collect();
        if !list.is_empty() {
            self.put(key, list);
        }
    }

    /// A text, or a list of several.
    pub(super) fn one_or_many(&mut self, key: &str, texts: impl IntoIterator<Item = String>) {
        let texts: Vec<String> = texts.into_iter().collect();
        match texts.as_slice() {
            [only] => self.text(key, only),
            _ => self.list(key, texts),
        }
    }

    /// A table in one line.
    pub(super) fn inline(&mut self, key: &str, keys: Self) {
        if !keys.is_empty() {
            self.put(key, inline(keys));
        }
    }

    /// A list of tables, one in a line.
    pub(super) fn tables(&mut self, key: &str, tables: impl Iterator<Item = Self>) {
        let mut list = Array::new();
        for table in tables {
            let mut table = Toml::InlineTable(inline(table));
            table.decor_mut().set_prefix("\n  ");
            list.push_formatted(table);
        }
        list.set_trailing("\n");
        list.set_trailing_comma(true);
        if !list.is_empty() {
            self.put(key, list);
        }
    }

    pub(super) fn items(self) -> impl Iterator<Item = (Key, Item)> {
        let keys = self.0.into_iter();
        keys.map(|(key, value)| (Key::new(key), Item::Value(value)))
    }
}

pub(super) fn inline(keys: Keys) -> InlineTable {
    keys.0.into_iter().collect()
}

pub(super) fn table(keys: Keys) -> Table {
    let mut table = Table::new();
    table.extend(keys.items());
    table
}

pub(super) fn tables(all: impl Iterator<Item = Keys>) -> ArrayOfTables {
    all.map(table).collect()
}

/// A value, in which a dollar stands for itself.
pub(crate) fn value(value: &Value) -> Toml {
    match value {
        Value::Boolean(truth) => (*truth).into(),
        Value::Integer(number) => (*number).into(),
        Value::Real(number) => (*number).into(),
        Value::Text(text) if text.contains("${") || text.contains("$$") => {
            text.replace('$', "$$").into()
        }
        Value::Text(text) => text.into(),
        Value::Secret(_) => REDACTED.into(),
        Value::List(items) => Toml::Array(items.iter().map(self::value).collect()),
        Value::Record(fields) => {
            let fields = fields.iter();
            let fields = fields.map(|(name, field)| (name.clone(), self::value(field)));
            Toml::InlineTable(fields.collect())
        }
    }
}

/// The path of a file as the file at `root` names it.
pub fn beside(root: &str, path: &str) -> String {
    let mut folder: Vec<&str> = root.split('/').collect();
    folder.pop();
    let parts: Vec<&str> = path.split('/').collect();
    let is_absolute = |parts: &[&str]| parts.first().is_some_and(|first| first.is_empty());
    if is_absolute(&parts) != is_absolute(&folder) {
        return path.to_owned();
    }
    let pairs = folder.iter().zip(&parts);
    let common = pairs.take_while(|(one, other)| one == other).count();
    let up = std::iter::repeat_n("..", folder.len() - common);
    let down = parts.iter().skip(common).copied();
    up.chain(down).collect::<Vec<_>>().join("/")
}
