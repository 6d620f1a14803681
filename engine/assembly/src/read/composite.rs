//! The file as a whole.

use crate::codes::c008::UnknownSchema;
use asmotion_diagnostics::FileId;

use super::keys::{Keys, Reader};
use super::outline::Way;
use super::{component, deploy, endpoint, promote, setting, top, topic, wiring};
use crate::At;
use crate::finding::Findings;
use crate::model::Composite;
use crate::tree::Table;

/// The dialect this version reads.
const SCHEMA: &str = "composite/1";

pub(crate) fn composite(reader: &mut Reader<'_>, file: FileId, root: &Table) -> Option<Composite> {
    let mut keys = reader.keys(root, "a composite file", top(file));
    schema(&mut keys, SCHEMA);
    // those of the base are here by now
    keys.text("base", "\"navigation.composite.toml\"");
    keys.need("composite", "{ name = \"navigation\" }");
    let head = keys.table(
        "composite",
        "`composite`",
        "{ name = \"navigation\" }",
        |mut keys| {
            let name = keys.needed_text("name", "\"navigation\"");
            let version = keys.text("version", "\"1.0.0\"");
            let namespace = keys.text("namespace", "\"http://robots.example/navigation\"");
            let doc = keys.text("doc", "\"what it is for\"");
            let types = keys.texts("types", "[\"types.toml\"]");
            (name, version, namespace, doc, types)
        },
    );
    let (name, version, namespace, doc, types) = head.unwrap_or_default();
    Some(Composite {
        file,
        name: name.unwrap_or_else(|| At::new("composite".to_owned(), top(file))),
        version,
        namespace,
        doc,
        types,
        properties: keys.named("properties", "{ }", setting::property),
        brokers: keys.named("brokers", "{ }", endpoint::broker),
        gateways: keys.named("gateways", "{ }", endpoint::gateway),
        bridges: keys.named("bridges", "{ }", endpoint::bridge),
        components: keys.named("components", "{ }", component::component),
        topics: keys.named("topics", "{ }", topic::topic),
        wires: keys.items("wires", "tables", "[[wires]]", wiring::wire),
        connections: keys.items(
            "connections",
            "tables",
            "[[connections]]",
            wiring::connection,
        ),
        promotions: keys.items("promote", "tables", "[[promote]]", promote::promotion),
        deploy: keys.table("deploy", "`deploy`", "{ }", deploy::deploy),
    })
}

/// Checks the line that says which dialect this is.
pub(crate) fn schema(keys: &mut Keys<'_, '_, '_>, wanted: &'static str) {
    let example = format!("\"{wanted}\"");
    keys.need("schema", &example);
    let node = keys.ask("schema", Way::word(std::iter::once(wanted)));
    let found = node.and_then(|node| keys.reader.plain("schema", node, &example));
    let Some(found) = found else {
        return;
    };
    if found.value != wanted {
        let (found, at) = (found.value, found.span);
        keys.reader
            .report
            .found(UnknownSchema { found, wanted, at });
    }
}
