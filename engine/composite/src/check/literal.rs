//! Checks literal values of messages and arguments against their types.

use asmotion_datum::{Schema, Shape};
use asmotion_diagnostics::{Report, Span};

use crate::at::At;
use crate::codes::c100::WrongArgument;
use crate::codes::c115::UnknownField;
use crate::finding::Findings;
use crate::tree::{Branch, Node};
use crate::types::Types;

/// Checks a literal value for the port, field or operation `what`. Strings containing substitutions are accepted for every
/// type; fields of a record may be omitted.
pub(super) fn check(
    types: &Types<'_>,
    what: &At<String>,
    node: &Node,
    wanted: &Schema,
    report: &mut Report,
) {
    let fits = match (&wanted.shape, &node.value) {
        (Shape::Any, _) => true,
        (_, Branch::Text(text)) if text.contains("${") => true,
        (Shape::Text, Branch::Text(_)) | (Shape::Bool, Branch::Boolean(_)) => true,
        (Shape::F32 | Shape::F64, Branch::Integer(_) | Branch::Float(_)) => true,
        (Shape::List(item) | Shape::Array(item, _), Branch::List(items)) => {
            items
                .iter()
                .for_each(|node| check(types, what, node, item, report));
            true
        }
        (Shape::Record(known), Branch::Table(table)) => {
            for entry in &table.entries {
                let name = &entry.key;
                match known.iter().find(|field| field.name == name.value.as_str()) {
                    Some(field) => check(types, name, &entry.node, &field.schema, report),
                    None => report.found(UnknownField {
                        name: wanted.to_string(),
                        field: name.value.clone(),
                        at: name.span,
                        known: known.iter().map(|field| field.name.to_string()).collect(),
                        declared: types.declared(&wanted.name),
                    }),
                }
            }
            true
        }
        (shape, Branch::Integer(_)) if shape.is_integer() => true,
        (Shape::Option(inner), _) => {
            check(types, what, node, inner, report);
            true
        }
        _ => false,
    };
    if !fits {
        let found = node.value.describe().to_owned();
        wrong(what, wanted, "this", found, node.span, report);
    }
}

/// Reports a value of another type than `wanted`.
pub(super) fn wrong(
    what: &At<String>,
    wanted: &Schema,
    given: &str,
    found: String,
    at: Span,
    report: &mut Report,
) {
    report.found(WrongArgument {
        what: what.value.clone(),
        wanted: wanted.to_string(),
        given: given.to_owned(),
        found,
        at,
    });
}
