//! `[topics.<name>]`.

use super::keys::Reader;
use super::name;
use crate::At;
use crate::model::Topic;
use crate::tree::Node;

pub(crate) fn topic(reader: &mut Reader<'_>, key: &At<String>, node: &Node) -> Option<Topic> {
    let name = name::topic(reader, key)?;
    let mut keys = reader.keys_of(node, key, "a topic", "{ confirm = true }")?;
    Some(Topic {
        name,
        confirm: keys.flag("confirm"),
        outage: keys.word("outage"),
        size: keys.whole("size", 1..=1_000_000),
        codec: keys.word("codec"),
    })
}
