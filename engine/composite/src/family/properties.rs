//! Checks the properties of a composite: limits without effect, and properties that nothing uses.

use std::borrow::Cow;
use std::collections::BTreeSet;

use asmotion_diagnostics::Report;

use crate::codes::c048::IdleKey;
use crate::finding::Findings;
use crate::model::{Composite, Property, Scalar};
use crate::nearest::nearest_name;
use crate::template::{self, Piece};
use crate::tree::{Branch, Node, Table};

/// Checks the properties of a composite that was read from a tree.
pub(super) fn check(composite: &Composite, tree: &Table, report: &mut Report) {
    let mut used = BTreeSet::new();
    for entry in &tree.entries {
        collect(&entry.key.value, &entry.node, &mut used);
    }
    let names = || composite.properties.iter().map(|it| it.name.value.as_str());
    // one mistake, one message: a misspelt name is reported where it is used
    let unknown = used.iter().filter(|used| !names().any(|it| it == **used));
    let meant = unknown.filter_map(|used| nearest_name(used, names()));
    let meant: BTreeSet<String> = meant.map(|it| it.name).collect();
    for property in &composite.properties {
        limits(property, report);
        let name = &property.name;
        if !used.contains(&name.value) && !meant.contains(&name.value) {
            report.found(IdleKey {
                key: Cow::Owned(format!("properties.{}", name.value)),
                at: name.span,
                reason: "no value of the composite contains it as `${properties.…}`",
            });
        }
    }
}

/// Adds the names of the properties that a value contains.
fn collect(key: &str, node: &Node, used: &mut BTreeSet<String>) {
    match &node.value {
        Branch::Text(text) if key != "doc" => {
            let template = template::parse(text, node.span, false);
            let pieces = template.map_or_else(|_| Vec::new(), |it| it.pieces);
            used.extend(pieces.into_iter().filter_map(|piece| match piece {
                Piece::Property { name, .. } => Some(name),
                Piece::Text(_) | Piece::Variable { .. } => None,
            }));
        }
        Branch::List(items) => items.iter().for_each(|item| collect(key, item, used)),
        Branch::Table(table) => {
            for entry in &table.entries {
                collect(&entry.key.value, &entry.node, used);
            }
        }
        Branch::Text(_)
        | Branch::Integer(_)
        | Branch::Float(_)
        | Branch::Boolean(_)
        | Branch::Date(_) => {}
    }
}

/// Reports limits of a type without numbers.
fn limits(property: &Property, report: &mut Report) {
    let reason = match property.kind.value.scalar {
        Scalar::Text | Scalar::Uri | Scalar::Path | Scalar::Secret => {
            "only numbers have limits, and this is a string"
        }
        Scalar::Boolean => "only numbers have limits, and this is `true` or `false`",
        Scalar::I8
        | Scalar::I16
        | Scalar::I32
        | Scalar::I64
        | Scalar::U8
        | Scalar::U16
        | Scalar::U32
        | Scalar::U64
        | Scalar::F32
        | Scalar::F64 => return,
    };
    let keys = [("min", &property.min), ("max", &property.max)];
    for (key, limit) in keys {
        if let Some(limit) = limit {
            report.found(IdleKey {
                key: Cow::Borrowed(key),
                at: limit.span,
                reason,
            });
        }
    }
}
