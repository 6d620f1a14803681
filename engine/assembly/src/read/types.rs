//! A file of message types.

use crate::codes::c009::InvalidName;
use asmotion_diagnostics::FileId;

use super::composite::schema;
use super::keys::Reader;
use super::top;
use crate::At;
use crate::finding::Findings;
use crate::tree::{Node, Table};
use crate::types::{Definition, TypeFile, TypeText, split};

/// The dialect this version reads.
const SCHEMA: &str = "composite-types/1";

pub(crate) fn types(reader: &mut Reader<'_>, file: FileId, root: &Table) -> Option<TypeFile> {
    let mut keys = reader.keys(root, "a file of types", top(file));
    schema(&mut keys, SCHEMA);
    let definitions = keys.named("type", "{ }", definition);
    Some(TypeFile { definitions })
}

fn definition(reader: &mut Reader<'_>, key: &At<String>, node: &Node) -> Option<Definition> {
    let example = "{ fields = { stamp = \"time\", position = \"f64[5]\" } }";
    let mut keys = reader.keys_of(node, key, "a type", example)?;
    keys.span = key.span;
    keys.need("fields", "{ stamp = \"time\", position = \"f64[5]\" }");
    keys.text("doc", "\"what it is for\"");
    let fields = keys.named("fields", "{ stamp = \"time\" }", |reader, key, node| {
        let written = reader.text(key, node, "\"f64[5]\"")?;
        Some((key.clone(), type_text(reader, &written)?))
    });
    Some(Definition {
        name: key.clone(),
        fields,
    })
}

fn type_text(reader: &mut Reader<'_>, written: &At<String>) -> Option<TypeText> {
    let Some((base, many)) = split(written) else {
        reader.report.found(InvalidName {
            text: written.value.clone(),
            what: "a type",
            rule: "a type is a name, a list `name[]` or an array `name[5]`",
            at: written.span,
        });
        return None;
    };
    let span = reader.part(written, 0..base.len());
    Some(TypeText {
        base: At::new(base.to_owned(), span),
        many,
    })
}
