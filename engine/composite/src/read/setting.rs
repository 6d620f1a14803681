//! Values that texts are substituted in.

use super::keys::Reader;
use crate::tree::{Branch, Node};

/// Reads all substitutions in a value, only to say which are malformed.
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
