//! Parses composite files into a [`Composite`] without semantic checks.

use std::collections::BTreeSet;

use asmotion_diagnostics::{FileId, Report, Span};

use crate::at::At;
use crate::codes::c001::InvalidToml;
use crate::codes::c002::UnreadableComposite;
use crate::codes::c009::InvalidName;
use crate::finding::Findings;
use crate::instances::{self, RangeProperties};
use crate::misspelt;
use crate::model::{Composite, Terminal};
use crate::table::Table as _;
use crate::table::derived::Reader;
use crate::tree::{self, Table};

/// Maximum size of a composite file in bytes.
pub const MAX_BYTES: usize = 1 << 20;

/// Maximum number of syntax errors reported; later ones are mostly consequences of the first.
const MAX_SYNTAX_ERRORS: usize = 10;

/// A composite read from the tree of its file.
pub(crate) struct ReadComposite {
    /// The model, incomplete if there are errors; `None` if nothing could be read, or if it is unknown which elements there are.
    pub composite: Option<Composite>,
    /// Places of the elements that stand for several instances.
    pub repeated: Vec<Span>,
    /// Properties on which numbers of instances depend.
    pub counting: BTreeSet<String>,
    /// Entries of tables of names that could not be read: the key of the table, and the name.
    pub unread: Vec<(&'static str, String)>,
    pub report: Report,
}

/// Reads a composite from a TOML tree. `settings` are properties that are set from outside.
pub(crate) fn composite(
    file: FileId,
    text: &str,
    tree: &Table,
    settings: &[(String, String)],
) -> ReadComposite {
    let mut reader = Reader::new(text);
    let top = top(file);
    let (mut tree, outline) = (tree.clone(), Composite::outline());
    misspelt::correct(&mut tree, &outline, &mut reader.report);
    let mut found = Report::new();
    let properties = RangeProperties::new(&tree, settings);
    let expanded = instances::expand(&mut tree, &outline, &properties, &mut found);
    reader.instances = expanded.places;
    let are_expanded = !found.has_errors();
    reader.report.extend(found);
    let mut keys = reader.keys(&tree, outline.of, top);
    let composite = Composite::read_keys(&mut keys, &At::new(String::new(), top));
    drop(keys);
    let is_known = composite
        .as_ref()
        .is_none_or(|it| has_known_ends(it, &mut reader));
    let is_known = is_known && are_expanded;
    ReadComposite {
        // missing elements would be reported wherever they are named
        composite: composite.filter(|_| is_known),
        counting: expanded.properties,
        repeated: reader.instances.into_iter().map(|(at, _)| at).collect(),
        unread: reader.unread,
        report: reader.report,
    }
}

/// Reports the ends of connections and wires with a variable that the `for` of the element does not have. Returns whether there
/// are none.
fn has_known_ends(composite: &Composite, reader: &mut Reader<'_>) -> bool {
    let connections = composite.connections.iter();
    let terminals = connections.flat_map(|it| it.from.iter().chain(&it.to));
    let ports = terminals.filter_map(|it| match it {
        Terminal::Port(end) => Some(end),
        Terminal::Topic(_) | Terminal::Mqueue(_) => None,
    });
    let wires = composite.wires.iter();
    let wired = wires.flat_map(|it| std::iter::once(&it.reference).chain(&it.services));
    let mut is_known = true;
    for name in ports
        .chain(wired)
        .flat_map(|end| [&end.component, &end.name])
    {
        if let Some(variable) = reader.unknown_variable(name, name.span) {
            is_known = false;
            reader.report.found(InvalidName {
                text: name.value.clone(),
                what: "a connection end",
                rule: "",
                at: name.span,
                variable: Some(variable),
            });
        }
    }
    is_known
}

/// Parses a TOML file; `None` if nothing could be parsed.
pub(crate) fn tree(file: FileId, path: &str, text: &str) -> (Option<Table>, Report) {
    let mut report = Report::new();
    if text.len() > MAX_BYTES {
        let reason = format!("it has {} bytes, more than {MAX_BYTES}", text.len());
        let path = path.to_owned();
        report.found(UnreadableComposite {
            path,
            reason,
            at: None,
        });
        return (None, report);
    }
    let (table, errors) = tree::parse(file, text);
    let damaged = !errors.is_empty();
    for error in errors.into_iter().take(MAX_SYNTAX_ERRORS) {
        let tree::TomlError {
            message,
            span: at,
            earlier,
        } = error;
        report.found(InvalidToml {
            message,
            at,
            earlier,
        });
    }
    if damaged && table.entries.is_empty() {
        (None, report)
    } else {
        (Some(table), report)
    }
}

/// Returns the start of a file, used as the location of missing top-level keys.
pub(crate) fn top(file: FileId) -> Span {
    Span::new(file, 0, 0)
}
