//! `[[promote]]`.

use source::Span;

use super::error::ReadError;
use super::keys::{Keys, Reader};
use super::name;
use crate::At;
use crate::finding::Findings;
use crate::model::{Promoted, Promotion};
use crate::tree::Node;

pub(crate) fn promotion(reader: &mut Reader<'_>, node: &Node) -> Option<Promotion> {
    let example = "{ service = \"Planner.planning\", as = \"planning\" }";
    let mut keys = reader.keys_of(node, "promote", "a promotion", example)?;
    let span = keys.span;
    let what = promoted(&mut keys);
    let name = keys.needed_text("as", "\"planning\"");
    let name = name.and_then(|name| name::topic(keys.reader, &name));
    let profiles = keys.texts("profile", "\"sim\"");
    let (binding, broker) = (keys.word("binding"), keys.text("broker", "\"main\""));
    let optional = keys.flag("optional").is_some_and(|optional| optional.value);
    Some(Promotion {
        span,
        profiles,
        what: what?,
        name: name?,
        binding,
        broker,
        optional,
    })
}

/// Which of the five keys names what is promoted, and what it names.
fn promoted(keys: &mut Keys<'_, '_, '_>) -> Option<Promoted> {
    let mut found: Vec<(&'static str, Span, At<String>)> = Vec::new();
    for key in ["service", "reference", "property", "port", "topic"] {
        if let Some((span, node)) = keys.entry(key)
            && let Some(text) = keys.reader.text(key, node, "\"Component.name\"")
        {
            found.push((key, span, text));
        }
    }
    let mut found = found.into_iter();
    let Some((first, first_at, text)) = found.next() else {
        keys.need("service", "\"Component.name\"");
        return None;
    };
    for (second, at, _) in found {
        keys.reader.report.found(ReadError::Excluded {
            first: first.to_owned(),
            first_at,
            second: second.to_owned(),
            at,
            reason: "one promotion promotes one thing",
        });
    }
    if first == "topic" {
        return name::topic(keys.reader, &text).map(Promoted::Topic);
    }
    let end = name::end(keys.reader, &text)?;
    Some(match first {
        "service" => Promoted::Service(end),
        "reference" => Promoted::Reference(end),
        "property" => Promoted::Property(end),
        _ => Promoted::Port(end),
    })
}
