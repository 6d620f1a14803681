//! Parses composite files into a [`Composite`] without semantic checks.

use asmotion_diagnostics::{FileId, Report, Span};

use crate::at::At;
use crate::codes::c001::InvalidToml;
use crate::codes::c002::UnreadableComposite;
use crate::finding::Findings;
use crate::misspelt;
use crate::model::Composite;
use crate::table::Table as _;
use crate::table::derived::Reader;
use crate::tree::{self, Table};

/// Maximum size of a composite file in bytes.
pub const MAX_BYTES: usize = 1 << 20;

/// Maximum number of syntax errors reported; later ones are mostly consequences of the first.
const MAX_SYNTAX_ERRORS: usize = 10;

/// Reads a composite from a TOML tree. The model is incomplete if there are errors, and `None` if nothing could be
/// read.
pub(crate) fn composite(file: FileId, text: &str, tree: &Table) -> (Option<Composite>, Report) {
    let mut reader = Reader::new(text);
    let top = top(file);
    let (mut tree, outline) = (tree.clone(), Composite::outline());
    misspelt::correct(&mut tree, &outline, &mut reader.report);
    let mut keys = reader.keys(&tree, outline.of, top);
    let composite = Composite::read_keys(&mut keys, &At::new(String::new(), top));
    drop(keys);
    (composite, reader.report)
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
