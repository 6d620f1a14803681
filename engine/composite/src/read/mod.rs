//! Text → tree → [`Composite`]: everything that can be said without knowing what it means.

pub(crate) mod binding;
mod component;
pub(crate) mod keys;
pub(crate) mod name;
pub(crate) mod setting;
pub(crate) mod template;

use asmotion_diagnostics::{FileId, Report, Span};

pub(crate) use self::component::belongs;
use self::keys::Reader;
use crate::at::At;
use crate::codes::c001::InvalidToml;
use crate::codes::c002::UnreadableComposite;
use crate::finding::Findings;
use crate::model::Composite;
use crate::table::Table as _;
use crate::tree::{self, Table};

/// Larger files are not composites.
pub const MAX_BYTES: usize = 1 << 20;

/// So many places that are not TOML are shown; the rest is mostly their echo.
const MAX_SYNTAX_ERRORS: usize = 10;

/// Reads a composite from the tree of its file: the model as far as it can be made out, and every finding.
pub(crate) fn composite(file: FileId, text: &str, tree: &Table) -> (Option<Composite>, Report) {
    let mut reader = Reader::new(text);
    let top = top(file);
    let mut keys = reader.keys(tree, Composite::outline().of, top);
    let composite = Composite::read_keys(&mut keys, &At::new(String::new(), top));
    drop(keys);
    (composite, reader.report)
}

/// Reads a file as a tree, and says where it is no TOML. `None` where nothing of it can be made out.
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

/// The start of a file: where a key that is missing at the top should stand.
pub(crate) fn top(file: FileId) -> Span {
    Span::new(file, 0, 0)
}
