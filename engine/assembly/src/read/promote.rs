//! `[[promote]]`.

use super::endpoint::DAY_MS;
use super::keys::{Keys, Reader};
use super::name;
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
    let bindings = keys.words("binding");
    let broker = keys.text("broker", "\"main\"");
    let gateway = keys.text("gateway", "\"main\"");
    let timeout_ms = keys.whole("timeout_ms", 1..=DAY_MS);
    let optional = keys.flag("optional").is_some_and(|optional| optional.value);
    Some(Promotion {
        span,
        profiles,
        what: what?,
        name: name?,
        bindings,
        broker,
        gateway,
        timeout_ms,
        optional,
    })
}

const KINDS: &[&str] = &["service", "reference", "property", "port", "topic"];

/// Which of the five keys names what is promoted, and what it names.
fn promoted(keys: &mut Keys<'_, '_, '_>) -> Option<Promoted> {
    let reason = "one promotion promotes one thing";
    let (kind, text) = keys.one_of(KINDS, "\"Component.name\"", reason)?;
    if kind == "topic" {
        return name::topic(keys.reader, &text).map(Promoted::Topic);
    }
    let end = name::end(keys.reader, &text)?;
    Some(match kind {
        "service" => Promoted::Service(end),
        "reference" => Promoted::Reference(end),
        "property" => Promoted::Property(end),
        _ => Promoted::Port(end),
    })
}
