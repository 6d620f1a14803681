//! Properties of the composite, and properties being set.

use super::keys::Reader;
use super::name;
use super::outline::Way;
use crate::At;
use crate::codes::c006::UnknownOption;
use crate::finding::Findings;
use crate::model::{Property, PropertyType, Scalar, Setting};
use crate::nearest::nearest_name;
use crate::tree::{Branch, Node};
use asmotion_datum::Word;

pub(crate) fn property(reader: &mut Reader<'_>, key: &At<String>, node: &Node) -> Option<Property> {
    let name = name::thing(reader, key)?;
    let example = "{ type = \"f64\", default = 0.35, min = 0.0, max = 1.0 }";
    let mut keys = reader.keys_of(node, key, "a property", example)?;
    let any = f64::NEG_INFINITY..=f64::INFINITY;
    keys.need("type", "\"f64\"");
    let kind = keys.node("type").and_then(|node| kind(keys.reader, node));
    let default = keys.node("default").cloned();
    if let Some(default) = &default {
        templates(keys.reader, "default", default);
    }
    let (min, max) = (keys.real("min", any.clone()), keys.real("max", any));
    let doc = keys.text("doc", "\"what it is for\"");
    Some(Property {
        name,
        kind: kind?,
        default,
        min,
        max,
        doc,
    })
}

/// `f64`, `string[]`.
fn kind(reader: &mut Reader<'_>, node: &Node) -> Option<At<PropertyType>> {
    let one = Scalar::words().into_iter().map(str::to_owned);
    let many = Scalar::words().into_iter().map(|word| format!("{word}[]"));
    reader.asked.add(Way::Word(one.chain(many).collect()));
    let word = reader.plain("type", node, "\"f64\"")?;
    let (scalar, list) = match word.strip_suffix("[]") {
        Some(scalar) => (scalar, true),
        None => (word.as_str(), false),
    };
    if let Some(scalar) = Scalar::of_word(scalar) {
        return Some(At::new(PropertyType { scalar, list }, word.span));
    }
    let known = Scalar::words();
    reader.report.found(UnknownOption {
        key: "type".to_owned(),
        nearest: nearest_name(scalar, known.iter().copied()),
        word: word.value,
        at: word.span,
        known,
    });
    None
}

/// A property of a component, with its value.
pub(crate) fn setting(reader: &mut Reader<'_>, key: &At<String>, node: &Node) -> Option<Setting> {
    templates(reader, key, node);
    Some(Setting {
        name: key.clone(),
        value: node.clone(),
    })
}

/// Reads all substitutions in a value, only to say which are malformed.
pub(crate) fn templates(reader: &mut Reader<'_>, key: &str, node: &Node) {
    reader.asked.add(Way::Any);
    match &node.value {
        Branch::Text(_) => {
            reader.template(key, node, "\"text\"");
        }
        Branch::List(items) => items.iter().for_each(|item| templates(reader, key, item)),
        Branch::Table(table) => {
            table
                .entries
                .iter()
                .for_each(|entry| templates(reader, key, &entry.node));
        }
        Branch::Integer(_) | Branch::Float(_) | Branch::Boolean(_) | Branch::Date(_) => {}
    }
}
