//! Keys that are misspelt or in the wrong table: each is reported once, and its value is read as that of the key that was meant, so
//! that nothing else seems to be missing.

use asmotion_diagnostics::Report;

use crate::codes::c003::UnknownKey;
use crate::finding::Findings;
use crate::nearest::{Nearest, nearest_name};
use crate::table::{Many, Outline};
use crate::tree::{Branch, Entry, Node, Table};

/// Keys of other dialects and their equivalents.
const MEANT: &[(&str, &str)] = &[("file", "asm"), ("spec", "asm"), ("specification", "asm")];

/// Keys of an implementation that can stand directly in a component by mistake, with the key that is meant.
const IMPLEMENTATIONS: &[(&str, &str)] = &[
    ("asm", "asm"),
    ("file", "asm"),
    ("rust", "rust"),
    ("composite", "composite"),
    ("builtin", "builtin"),
];

/// Corrects the keys of a table and of the tables in it. Reports those that are corrected.
pub(crate) fn correct(table: &mut Table, outline: &Outline, report: &mut Report) {
    let present: Vec<String> = table
        .entries
        .iter()
        .map(|it| it.key.value.clone())
        .collect();
    let mut corrected = Table::default();
    for entry in std::mem::take(&mut table.entries) {
        match correction(&entry, &present, outline) {
            None => merge(&mut corrected, entry),
            Some((finding, entry)) => {
                report.found(finding);
                merge(&mut corrected, entry);
            }
        }
    }
    *table = corrected;
    for Entry { key, node } in &mut table.entries {
        let mut keys = outline.keys.iter().map(|(key, _)| *key);
        let Some(known) = keys.find(|known| known.name == key.value) else {
            continue;
        };
        let Some(inner) = (known.table)(known) else {
            continue;
        };
        for table in tables(node, known.many == Some(Many::Names)) {
            correct(table, &inner, report);
        }
    }
}

/// The entry that is meant by one with an unknown key, with the finding about it; `None` if the key is known or a name, or if it
/// resembles none.
fn correction(entry: &Entry, present: &[String], outline: &Outline) -> Option<(UnknownKey, Entry)> {
    let written = entry.key.value.as_str();
    if outline.has_names || outline.keys.iter().any(|(key, _)| key.name == written) {
        return None;
    }
    // some keys are permitted only beside another one
    let is_permitted =
        |with: Option<&str>| with.is_none_or(|it| present.iter().any(|key| key == it));
    let permitted = outline.keys.iter().filter(|(_, with)| is_permitted(*with));
    let known: Vec<&str> = permitted.map(|(key, _)| key.name).collect();
    let is_known = |meant: &&(&str, &str)| meant.0 == written && known.contains(&meant.1);
    let finding = |nearest, instead| UnknownKey {
        key: written.to_owned(),
        of: outline.of,
        at: entry.key.span,
        known: outline.keys.iter().map(|(key, _)| key.name).collect(),
        nearest,
        instead,
    };
    if let Some((_, meant)) = MEANT.iter().find(is_known) {
        let nearest = Nearest {
            name: (*meant).to_owned(),
            declared: None,
        };
        return Some((finding(Some(nearest), None), renamed(entry, meant)));
    }
    let mut implementations = IMPLEMENTATIONS.iter();
    let implementation = implementations.find(|(key, _)| *key == written);
    if let (Some((_, meant)), Branch::Text(value)) = (implementation, &entry.node.value)
        && known.contains(&"implementation")
    {
        let instead = format!("implementation = {{ {meant} = \"{value}\" }}");
        let table = Table {
            entries: [renamed(entry, meant)].into_iter().collect(),
        };
        let mut entry = renamed(entry, "implementation");
        entry.node.value = Branch::Table(table);
        return Some((finding(None, Some(instead)), entry));
    }
    let nearest = nearest_name(written, known.iter().copied())?;
    let entry = renamed(entry, &nearest.name);
    Some((finding(Some(nearest), None), entry))
}

fn renamed(entry: &Entry, key: &str) -> Entry {
    let mut entry = entry.clone();
    key.clone_into(&mut entry.key.value);
    entry
}

/// Adds an entry. Tables and lists of the same key are combined; otherwise the first value counts.
fn merge(table: &mut Table, entry: Entry) {
    let mut known = table.entries.iter_mut();
    let Some(known) = known.find(|known| known.key.value == entry.key.value) else {
        table.entries.push(entry);
        return;
    };
    match (&mut known.node.value, entry.node.value) {
        (Branch::Table(under), Branch::Table(over)) => under.lay(over),
        (Branch::List(items), Branch::List(others)) => items.extend(others),
        (_, _) => {}
    }
}

/// The tables of a value: itself, those of a list, or those under names.
fn tables(node: &mut Node, is_named: bool) -> Vec<&mut Table> {
    match &mut node.value {
        Branch::Table(table) => {
            if !is_named {
                return vec![table];
            }
            let entries = table.entries.iter_mut();
            entries.flat_map(|it| tables(&mut it.node, false)).collect()
        }
        Branch::List(items) => {
            let items = items.iter_mut();
            items.flat_map(|item| tables(item, false)).collect()
        }
        Branch::Text(_)
        | Branch::Integer(_)
        | Branch::Float(_)
        | Branch::Boolean(_)
        | Branch::Date(_) => Vec::new(),
    }
}
