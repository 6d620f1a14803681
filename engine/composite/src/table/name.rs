//! Checks the form of names: of elements of a composite, and of topics.

use super::keys::Reader;
use crate::at::At;
use crate::codes::c009::InvalidName;
use crate::finding::Findings;

/// Reads the name of an element: letters, digits, `_` and `-`. In expanded composites it may be qualified:
/// `Driver/youBotDriver`.
pub(crate) fn thing(reader: &mut Reader<'_>, name: &At<String>) -> Option<At<String>> {
    let rule = "use letters, digits, `_` and `-`, starting with a letter";
    let letters = |letter: char| letter.is_alphanumeric() || letter == '_' || letter == '-';
    let good = |part: &str| {
        let starts = part.starts_with(|first: char| first.is_alphabetic() || first == '_');
        starts && part.chars().all(letters)
    };
    accept(reader, name, name.split('/').all(good), "a name", rule)
}

/// Reads a topic name, which may also contain `/` and `.`.
pub(crate) fn topic(reader: &mut Reader<'_>, name: &At<String>) -> Option<At<String>> {
    let rule = "use letters, digits, `_`, `-`, `/` and `.`";
    let letters =
        |letter: char| letter.is_alphanumeric() || matches!(letter, '_' | '-' | '/' | '.');
    accept(
        reader,
        name,
        !name.is_empty() && name.chars().all(letters),
        "a topic",
        rule,
    )
}

/// Accepts any name.
pub(crate) fn any(_: &mut Reader<'_>, name: &At<String>) -> Option<At<String>> {
    Some(name.clone())
}

/// Returns the name if it is `good`, and reports it with the `rule` otherwise.
pub(crate) fn accept(
    reader: &mut Reader<'_>,
    name: &At<String>,
    good: bool,
    what: &'static str,
    rule: &'static str,
) -> Option<At<String>> {
    if !good {
        let text: String = name.chars().take(60).collect();
        let variable = reader.unknown_variable(name, name.span);
        reader.report.found(InvalidName {
            text,
            what,
            rule,
            at: name.span,
            variable,
        });
        return None;
    }
    Some(name.clone())
}
