//! Text → tree → [`Composite`]: everything that can be said without knowing what it means.

mod binding;
mod component;
mod composite;
mod deploy;
mod endpoint;
pub(crate) mod error;
mod implementation;
mod keys;
pub(crate) mod name;
pub(crate) mod outline;
mod pace;
mod promote;
mod setting;
pub(crate) mod template;
mod topic;
mod types;
mod wiring;

use source::{FileId, Report, Span};

pub(crate) use self::endpoint::DAY_MS;
use self::error::ReadError;
use self::keys::Reader;
use self::outline::Asked;
use crate::finding::Findings;
use crate::model::Composite;
use crate::tree::{self, Table};
use crate::types::TypeFile;

/// Larger files are not composites.
pub const MAX_BYTES: usize = 1 << 20;

/// So many places that are not TOML are shown; the rest is mostly their echo.
const MAX_SYNTAX_ERRORS: usize = 10;

/// Reads a composite file: the model as far as it can be made out, and every finding.
pub fn composite(file: FileId, path: &str, text: &str) -> (Option<Composite>, Report) {
    read(file, path, text, composite::composite)
}

/// Reads a file of message types.
pub(crate) fn types(file: FileId, path: &str, text: &str) -> (Option<TypeFile>, Report) {
    read(file, path, text, types::types)
}

/// What the reader asks of a composite file, or of a file of types, that has one of everything.
pub(crate) fn outline(text: &str, types: bool) -> Asked {
    let file = FileId::default();
    let mut reader = Reader::new(text);
    let (table, _) = tree::parse(file, text);
    if types {
        types::types(&mut reader, file, &table);
    } else {
        composite::composite(&mut reader, file, &table);
    }
    reader.asked
}

fn read<T>(
    file: FileId,
    path: &str,
    text: &str,
    what: impl FnOnce(&mut Reader<'_>, FileId, &Table) -> Option<T>,
) -> (Option<T>, Report) {
    let mut reader = Reader::new(text);
    if text.len() > MAX_BYTES {
        let reason = format!("it has {} bytes, and {MAX_BYTES} is the most", text.len());
        let path = path.to_owned();
        reader.report.found(ReadError::Unreadable {
            path,
            reason,
            at: None,
        });
        return (None, reader.report);
    }
    let (table, errors) = tree::parse(file, text);
    let damaged = !errors.is_empty();
    for error in errors.into_iter().take(MAX_SYNTAX_ERRORS) {
        let tree::SyntaxError {
            message,
            span: at,
            earlier,
        } = error;
        reader.report.found(ReadError::Syntax {
            message,
            at,
            earlier,
        });
    }
    if damaged && table.entries.is_empty() {
        return (None, reader.report);
    }
    let read = what(&mut reader, file, &table);
    (read, reader.report)
}

/// The start of a file: where a key that is missing at the top should stand.
fn top(file: FileId) -> Span {
    Span::new(file, 0, 0)
}
