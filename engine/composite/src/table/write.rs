//! Tables as TOML, key by key.

use std::fmt::Display;
use std::net::SocketAddr;

use asmotion_coordinator::Constant;
use toml_edit::{Array, ArrayOfTables, InlineTable, Item, Key as Name, Table, Value as Toml};

use crate::address::Endpoint;
use crate::end::{End, Terminal};
use crate::value::{PropertyValues, REDACTED, SettingValue};

/// A value that can be written.
pub trait Written: Sized {
    /// As TOML; `None` for what is left out.
    fn toml(&self) -> Option<Toml>;

    /// Several of them.
    fn list(items: &[Self]) -> Option<Toml> {
        let list: Array = items.iter().filter_map(Self::toml).collect();
        (!list.is_empty()).then(|| list.into())
    }
}

/// A table that can be written.
pub trait WrittenTable {
    /// Its keys, under a key of this name.
    fn keys(&self, within: &str) -> Lines;
}

/// The keys of a table, in the order in which they are written.
#[derive(Default)]
pub struct Lines(Vec<(String, Toml)>);

impl Lines {
    /// No keys.
    pub fn new() -> Self {
        Self::default()
    }

    /// Returns `true` if nothing would be written.
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// A key and its value; nothing where that is left out.
    pub fn put(&mut self, key: &str, value: &impl Written) {
        self.put_some(key, value.toml());
    }

    /// A key and its value as TOML; nothing for `None`.
    pub fn put_some(&mut self, key: &str, value: Option<impl Into<Toml>>) {
        self.0
            .extend(value.map(|value| (key.to_owned(), value.into())));
    }

    /// A table in one line, unless it is empty.
    pub fn put_table(&mut self, key: &str, table: Self) {
        self.put_some(key, table.inline());
    }

    /// Adds the keys of another table behind these.
    pub fn append(&mut self, more: Self) {
        self.0.extend(more.0);
    }

    /// Without this key.
    pub fn without(mut self, key: &str) -> Self {
        self.0.retain(|(known, _)| known != key);
        self
    }

    /// All of them in one line.
    pub fn inline(self) -> Option<Toml> {
        (!self.is_empty()).then(|| self.0.into_iter().collect::<InlineTable>().into())
    }

    /// The keys as items of a [`Table`].
    pub fn items(self) -> impl Iterator<Item = (Name, Item)> {
        let keys = self.0.into_iter();
        keys.map(|(key, value)| (Name::new(key), Item::Value(value)))
    }
}

/// Keys as a table with a header of its own.
pub fn table(keys: Lines) -> Table {
    let mut table = Table::new();
    table.extend(keys.items());
    table
}

/// An array of tables, each with a header of its own.
pub fn tables(all: impl Iterator<Item = Lines>) -> ArrayOfTables {
    all.map(table).collect()
}

/// A list of tables, one in a line.
pub fn tables_of(items: &[impl Written]) -> Option<Toml> {
    let mut list = Array::new();
    for mut table in items.iter().filter_map(Written::toml) {
        table.decor_mut().set_prefix("\n  ");
        list.push_formatted(table);
    }
    list.set_trailing("\n");
    list.set_trailing_comma(true);
    (!list.is_empty()).then(|| list.into())
}

/// A list, empty or not.
pub fn list<T: Written>(items: &[T]) -> Toml {
    T::list(items).unwrap_or_else(|| Array::new().into())
}

/// A value by itself, or a list of several.
pub fn one_or_many<T: Written>(items: &[T]) -> Option<Toml> {
    match items {
        [only] => only.toml(),
        _ => T::list(items),
    }
}

/// Values by the text they are shown as.
macro_rules! shown {
    ($($kind:ty)*) => {
        $(impl Written for $kind {
            fn toml(&self) -> Option<Toml> {
                Some(text(self))
            }
        })*
    };
}

shown! { SocketAddr End Terminal }

fn text(value: &impl Display) -> Toml {
    value.to_string().into()
}

impl Written for String {
    fn toml(&self) -> Option<Toml> {
        Some(self.into())
    }
}

impl Written for bool {
    fn toml(&self) -> Option<Toml> {
        Some((*self).into())
    }
}

/// No number that is read from a file is too large for TOML.
impl Written for u64 {
    fn toml(&self) -> Option<Toml> {
        Some(i64::try_from(*self).unwrap_or(i64::MAX).into())
    }
}

impl Written for f64 {
    fn toml(&self) -> Option<Toml> {
        Some((*self).into())
    }
}

impl Written for Endpoint {
    fn toml(&self) -> Option<Toml> {
        Some(self.shown().into())
    }
}

impl Written for SettingValue {
    fn toml(&self) -> Option<Toml> {
        Some(toml(self))
    }
}

impl Written for Constant {
    fn toml(&self) -> Option<Toml> {
        Some(constant(self))
    }
}

impl<T: Written> Written for Option<T> {
    fn toml(&self) -> Option<Toml> {
        self.as_ref().and_then(Written::toml)
    }
}

impl<T: Written> Written for Vec<T> {
    fn toml(&self) -> Option<Toml> {
        T::list(self)
    }
}

impl Written for PropertyValues {
    fn toml(&self) -> Option<Toml> {
        let mut keys = Lines::new();
        for (name, value) in &self.0 {
            keys.put(name, value);
        }
        keys.inline()
    }
}

/// A value, in which a dollar stands for itself.
pub fn toml(value: &SettingValue) -> Toml {
    match value {
        SettingValue::Boolean(truth) => (*truth).into(),
        SettingValue::Integer(number) => (*number).into(),
        SettingValue::Real(number) => (*number).into(),
        SettingValue::Text(text) if text.contains("${") || text.contains("$$") => {
            text.replace('$', "$$").into()
        }
        SettingValue::Text(text) => text.into(),
        SettingValue::Secret(_) => REDACTED.into(),
        SettingValue::List(items) => Toml::Array(items.iter().map(self::toml).collect()),
        SettingValue::Record(fields) => {
            let fields = fields.iter();
            let fields = fields.map(|(name, field)| (name.clone(), self::toml(field)));
            Toml::InlineTable(fields.collect())
        }
    }
}

/// A constant of a binding, secrets left out.
pub fn constant(constant: &Constant) -> Toml {
    match (constant.secret, SettingValue::of_datum(&constant.datum)) {
        (false, Some(shown)) => toml(&shown),
        (true, _) | (_, None) => REDACTED.into(),
    }
}
