//! Reads type files.

use asmotion_diagnostics::{FileId, Report};
use serde_json::{Value as Json, json};

use super::{FieldText, TypeFile, TypeText, split};
use crate::at::At;
use crate::codes::c009::InvalidName;
use crate::finding::Findings;
use crate::read::{top, tree};
use crate::table::derived::Reader;
use crate::table::{Key, Many, Table as _, Value};
use crate::tree::Node;

/// Reads a type file; `None` if it could not be parsed.
pub(crate) fn read(file: FileId, path: &str, text: &str) -> (Option<TypeFile>, Report) {
    let (tree, mut report) = tree(file, path, text);
    let mut reader = Reader::new(text);
    let types = tree.and_then(|tree| {
        let top = top(file);
        let mut keys = reader.keys(&tree, TypeFile::outline().of, top);
        TypeFile::read_keys(&mut keys, &At::new(String::new(), top))
    });
    report.extend(reader.report);
    (types, report)
}

/// Reads a field such as `position = "f64[5]"`.
impl Value for FieldText {
    const MANY: Many = Many::Names;

    fn schema(_: &Key) -> Json {
        json!({ "type": "string" })
    }

    fn read(reader: &mut Reader<'_>, key: &At<String>, _: &Key, node: &Node) -> Option<Self> {
        let written = reader.text(key, node, "\"f64[5]\"")?;
        let Some((base, many)) = split(&written) else {
            reader.report.found(InvalidName {
                text: written.value.clone(),
                what: "a type",
                rule: "write a name, a list `name[]` or an array `name[5]`",
                at: written.span,
                variable: None,
            });
            // the field exists, so that its uses need no finding of their own
            let (name, text) = (key.clone(), None);
            return Some(Self { name, text });
        };
        let span = reader.part(&written, 0..base.len());
        let base = At::new(base.to_owned(), span);
        let (name, text) = (key.clone(), Some(TypeText { base, many }));
        Some(Self { name, text })
    }
}
