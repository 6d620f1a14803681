//! Lays out the bindings of an ASM component as tables with headers.

use toml_edit::{Item, Table};

use asmotion_composite::table::{Written, present};
use asmotion_coordinator::{Binding, Effect, Out};

/// Serialises the bindings, one function per line; the actions per literal of a function are a table of their own.
pub(super) fn bind(binding: &Binding) -> Table {
    let is_publication = |out: &&Out| matches!(out.effect, Effect::Publish(_));
    // a line after the header of a table would belong to that table
    let (lines, tables): (Vec<_>, Vec<_>) = binding.out.iter().partition(is_publication);
    let lines = lines
        .into_iter()
        .map(|out| (out.location.to_string(), line(out)));
    let tables = tables
        .into_iter()
        .map(|out| (out.location.to_string(), header(out)));
    let monitored = binding.monitored.iter();
    let monitored = monitored.map(|it| (it.location.to_string(), line(it)));
    let mut bind = Table::new();
    bind.set_implicit(true);
    for (key, table) in [
        ("monitored", monitored.collect::<Table>()),
        ("out", lines.chain(tables).collect()),
    ] {
        if !table.is_empty() {
            bind.insert(key, Item::Table(table));
        }
    }
    bind
}

/// Serialises a table as an inline table.
fn line(table: &impl Written) -> Item {
    Item::Value(present(table))
}

/// Serialises a table with a header.
fn header(table: &impl Written) -> Item {
    let item = Item::Value(present(table)).into_table();
    item.map_or_else(|value| value, Item::Table)
}
