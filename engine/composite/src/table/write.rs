//! Serialisation of tables as TOML.

use std::fmt::Display;
use std::net::SocketAddr;

use asmotion_coordinator::{BoundOperation, Constant};
use toml_edit::{Array, ArrayOfTables, InlineTable, Item, Key as Name, Table, Value as Toml};

use crate::address::Endpoint;
use crate::end::{End, Terminal};
use crate::value::{PropertyValues, REDACTED, SettingValue};

/// A value that can be serialised.
pub trait Written: Sized {
    /// Serialises the value; `None` if it is omitted.
    fn toml(&self) -> Option<Toml>;

    /// Serialises a list; `None` if it is empty.
    fn list(items: &[Self]) -> Option<Toml> {
        let list: Array = items.iter().filter_map(Self::toml).collect();
        (!list.is_empty()).then(|| list.into())
    }
}

/// A table that can be serialised.
pub trait WrittenTable {
    /// Returns the keys permitted under the key `within`.
    fn keys(&self, within: &str) -> Lines;
}

/// Keys and values of a table in output order.
#[derive(Default)]
pub struct Lines(Vec<(String, Toml)>);

impl Lines {
    /// Creates an empty list.
    pub fn new() -> Self {
        Self::default()
    }

    /// Returns `true` if there are no keys.
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// Adds a key unless the value is omitted.
    pub fn put(&mut self, key: &str, value: &impl Written) {
        self.put_some(key, value.toml());
    }

    /// Adds a key and its TOML value unless it is `None`.
    pub fn put_some(&mut self, key: &str, value: Option<impl Into<Toml>>) {
        self.0
            .extend(value.map(|value| (key.to_owned(), value.into())));
    }

    /// Adds an inline table unless it is empty.
    pub fn put_table(&mut self, key: &str, table: Self) {
        self.put_some(key, table.inline());
    }

    /// Appends the keys of another table.
    pub fn append(&mut self, more: Self) {
        self.0.extend(more.0);
    }

    /// Removes a key.
    pub fn without(mut self, key: &str) -> Self {
        self.0.retain(|(known, _)| known != key);
        self
    }

    /// Serialises as an inline table; `None` if empty.
    pub fn inline(self) -> Option<Toml> {
        (!self.is_empty()).then(|| self.0.into_iter().collect::<InlineTable>().into())
    }

    /// Iterates over the keys and values as items of a [`Table`].
    pub fn items(self) -> impl Iterator<Item = (Name, Item)> {
        let keys = self.0.into_iter();
        keys.map(|(key, value)| (Name::new(key), Item::Value(value)))
    }
}

/// Creates a table with a header.
pub fn table(keys: Lines) -> Table {
    let mut table = Table::new();
    table.extend(keys.items());
    table
}

/// Creates an array of tables, each with a header.
pub fn tables(all: impl Iterator<Item = Lines>) -> ArrayOfTables {
    all.map(table).collect()
}

/// Serialises a list of inline tables, one per line.
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

/// Serialises named tables as a table of their names; `None` if there are none.
pub fn named<'t, N: Display + 't, T: Written + 't>(
    items: impl Iterator<Item = (&'t N, &'t T)>,
) -> Option<Toml> {
    let mut keys = Lines::new();
    for (name, item) in items {
        keys.put_some(&name.to_string(), Some(present(item)));
    }
    keys.inline()
}

/// Serialises a value; an empty table if it would be omitted.
pub fn present(value: &impl Written) -> Toml {
    value.toml().unwrap_or_else(|| InlineTable::new().into())
}

/// Serialises a list, even if it is empty.
pub fn list<T: Written>(items: &[T]) -> Toml {
    T::list(items).unwrap_or_else(|| Array::new().into())
}

/// Serialises a single value as itself and several as a list.
pub fn one_or_many<T: Written>(items: &[T]) -> Option<Toml> {
    match items {
        [only] => only.toml(),
        _ => T::list(items),
    }
}

/// Implements `Written` through `Display`.
macro_rules! shown {
    ($($kind:ty)*) => {
        $(impl Written for $kind {
            fn toml(&self) -> Option<Toml> {
                Some(text(self))
            }
        })*
    };
}

shown! { SocketAddr End Terminal BoundOperation }

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

/// TOML integers are signed; values read from a file always fit.
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

/// Serialises a value of a table of names.
impl<T: Written> Written for (String, T) {
    fn toml(&self) -> Option<Toml> {
        self.1.toml()
    }

    fn list(items: &[Self]) -> Option<Toml> {
        named(items.iter().map(|(name, value)| (name, value)))
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

/// Serialises a value; dollar signs are escaped as `$$`.
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

/// Serialises a constant of a binding; secrets are masked.
fn constant(constant: &Constant) -> Toml {
    match (constant.secret, SettingValue::of_datum(&constant.datum)) {
        (false, Some(shown)) => toml(&shown),
        (true, _) | (_, None) => REDACTED.into(),
    }
}
