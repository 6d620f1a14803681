//! Merges a composite file with its base file and loaded property files into one tree, in which every key and value
//! keeps its source location.

use std::borrow::Cow;

use crate::codes::c048::IdleKey;
use crate::codes::c080::CircularInclusion;
use crate::codes::c129::{Missing, NothingToLeaveOut};
use asmotion_diagnostics::Span;

use super::Visit;
use super::removal::{self, NotRemoved};
use crate::at::At;
use crate::finding::Findings;
use crate::nearest::nearest_name;
use crate::read;
use crate::tree::{Branch, Node, Table};

/// Keys that a file does not inherit from its base.
const OF_EACH_FILE: [&str; 3] = ["schema", "base", "without"];

impl Visit<'_, '_> {
    /// Returns the tree of a composite file merged with its base and the property files of its components.
    pub(super) fn tree(&mut self, path: &str, at: Option<Span>) -> Option<Table> {
        let mut table = self.laid_over(path, at, &mut Vec::new())?;
        if let Some(Branch::Table(components)) = value_mut(&mut table, "components") {
            for component in &mut components.entries {
                if let Branch::Table(component) = &mut component.node.value {
                    self.load_properties(component);
                }
            }
        }
        Some(table)
    }

    /// Returns the tree of a file merged over its base. `above` lists the files derived from this one, to detect
    /// cycles.
    fn laid_over(
        &mut self,
        path: &str,
        at: Option<Span>,
        above: &mut Vec<String>,
    ) -> Option<Table> {
        let (file, text) = self.load(path, at)?;
        let (table, report) = read::tree(file, path, &text);
        self.report.extend(report);
        let table = table?;
        let Some(base) = text_at(&table, "base") else {
            if let Some(without) = table.get("without") {
                self.report.found(IdleKey {
                    key: Cow::Borrowed("without"),
                    at: without.key.span,
                    reason: "a composite without `base` inherits nothing",
                });
            }
            return Some(table);
        };
        above.push(path.to_owned());
        let found = self.resolve(&base)?;
        if above.contains(&found) {
            let at = base.span;
            self.report
                .found(CircularInclusion::Layer { path: found, at });
            return None;
        }
        let mut under = self.laid_over(&found, Some(base.span), above)?;
        self.leave_out(&table, &found, &mut under);
        under.lay(table);
        Some(under)
    }

    /// Removes what a file leaves out of its base. Reports what the base does not have, and what the file overrides as a whole.
    fn leave_out(&mut self, table: &Table, base: &str, under: &mut Table) {
        for path in texts_at(table, "without") {
            if let Some(key) = OF_EACH_FILE.iter().find(|it| **it == path.value) {
                let reason = "no file inherits this key from its base";
                self.report.found(IdleKey {
                    key: Cow::Borrowed(key),
                    at: path.span,
                    reason,
                });
                continue;
            }
            let is_set = removal::is_overridden(under, table, &path.value);
            let Err(reason) = removal::remove(under, &path.value) else {
                if is_set {
                    self.report.found(IdleKey {
                        key: Cow::Owned(path.value),
                        at: path.span,
                        reason: "this file sets it, in place of what its base says",
                    });
                }
                continue;
            };
            let reason = match reason {
                NotRemoved::Missing(known) => {
                    Missing::Unknown(nearest_name(&path, known.iter().map(String::as_str)))
                }
                NotRemoved::Nested { component, file } => Missing::Nested { component, file },
                NotRemoved::OfInstances(declared) => Missing::OfInstances(declared),
            };
            self.report.found(NothingToLeaveOut {
                path: path.value,
                at: path.span,
                base: base.to_owned(),
                reason,
            });
        }
    }

    /// Merges the loaded property file into the properties of a component, which take precedence.
    fn load_properties(&mut self, component: &mut Table) {
        let Some(named) = text_at(component, "load") else {
            return;
        };
        let Some(path) = self.resolve(&named) else {
            return;
        };
        let Some((file, text)) = self.load(&path, Some(named.span)) else {
            return;
        };
        let (loaded, report) = read::tree(file, &path, &text);
        self.report.extend(report);
        let own = match value_mut(component, "properties") {
            Some(Branch::Table(own)) => std::mem::take(own),
            // other types are reported by the reader
            Some(_) => return,
            None => Table::default(),
        };
        let mut properties = loaded.unwrap_or_default();
        properties.lay(own);
        component.set("properties", properties, named.span);
    }
}

fn value_mut<'t>(table: &'t mut Table, key: &str) -> Option<&'t mut Branch> {
    let entry = table.entries.iter_mut().find(|it| it.key.value == key)?;
    Some(&mut entry.node.value)
}

/// Returns the string value of a key; other types are reported by the reader.
fn text_at(table: &Table, key: &str) -> Option<At<String>> {
    text_of(&table.get(key)?.node)
}

/// Returns the string or the list of strings of a key; other types are reported by the reader.
fn texts_at(table: &Table, key: &str) -> Vec<At<String>> {
    match table.get(key).map(|entry| &entry.node) {
        Some(Node {
            value: Branch::List(items),
            ..
        }) => items.iter().filter_map(text_of).collect(),
        Some(node) => text_of(node).into_iter().collect(),
        None => Vec::new(),
    }
}

fn text_of(node: &Node) -> Option<At<String>> {
    let text = node.value.text()?;
    Some(At::new(text.to_owned(), node.span))
}
