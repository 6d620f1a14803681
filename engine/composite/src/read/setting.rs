//! Checks substitutions in values.

use super::keys::Reader;
use crate::tree::{Branch, Node};

/// Reports malformed substitutions in a value.
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
