//! Ends (`Component.port`), terminals (`topic:plan`), paths into messages and conditions, parsed from strings.

use super::component::{Condition, MessagePath};
use super::wiring::{End, Terminal};
use crate::at::At;
use crate::codes::c009::InvalidName;
use crate::finding::Findings;
use crate::table::derived::{Reader, name};

/// Stands in an [`End`] for the component that joins a service of ROS: `ros:/make_plan`. It is no name of a component.
pub(crate) const ROS: &str = "ros:";

/// Reads `Component.name`.
pub(super) fn end(reader: &mut Reader<'_>, text: &At<String>) -> Option<End> {
    if let Some(name) = text.strip_prefix(ROS) {
        let (prefix, length) = (ROS.len(), text.len());
        return Some(End {
            component: At::new(ROS.to_owned(), reader.part(text, 0..prefix)),
            name: At::new(name.to_owned(), reader.part(text, prefix..length)),
        });
    }
    let split = text.split_once('.').filter(|(component, name)| {
        !component.is_empty() && !name.is_empty() && !name.contains('.')
    });
    let Some((component, name)) = split else {
        let rule = "write two parts, as in `Component.port`";
        let text_shown = text.value.clone();
        let variable = reader.unknown_variable(text, text.span);
        reader.report.found(InvalidName {
            text: text_shown,
            what: "a connection end",
            rule,
            at: text.span,
            variable,
        });
        return None;
    };
    let (dot, length) = (component.len(), text.len());
    Some(End {
        component: At::new(component.to_owned(), reader.part(text, 0..dot)),
        name: At::new(name.to_owned(), reader.part(text, dot + 1..length)),
    })
}

/// Reads `Component.port`, `topic:name` or `mqueue:/name`.
pub(super) fn terminal(reader: &mut Reader<'_>, text: &At<String>) -> Option<Terminal> {
    let after = |prefix: &str| {
        let name = text.strip_prefix(prefix)?;
        let span = reader.part(text, prefix.len()..text.len());
        Some(At::new(name.to_owned(), span))
    };
    if let Some(name) = after("topic:") {
        return name::topic(reader, &name).map(Terminal::Topic);
    }
    match after("mqueue:") {
        Some(name) => queue(reader, &name).map(Terminal::Mqueue),
        None => end(reader, text).map(Terminal::Port),
    }
}

/// Reads the name of a message queue, such as `/jointStatus`.
fn queue(reader: &mut Reader<'_>, queue: &At<String>) -> Option<At<String>> {
    let rule = "write `/` and a name without `/`, as in `mqueue:/jointStatus`";
    let good = asmotion_mqueue::QueueName::new(queue).is_ok();
    name::accept(reader, queue, good, "a message queue", rule)
}

/// Reads a field path such as `pose.position.x`.
pub(super) fn path(reader: &mut Reader<'_>, text: &At<String>) -> Option<MessagePath> {
    let mut steps = Vec::new();
    let mut start = 0;
    for step in text.split('.') {
        if step.is_empty() {
            let rule = "write fields separated by dots, as in `pose.position.x`";
            reader.report.found(InvalidName {
                text: text.value.clone(),
                what: "a path",
                rule,
                at: text.span,
                variable: None,
            });
            return None;
        }
        let end = start + step.len();
        steps.push(At::new(step.to_owned(), reader.part(text, start..end)));
        start = end + 1;
    }
    Some(MessagePath {
        steps,
        span: text.span,
    })
}

/// Reads a condition that starts with `port.field`.
pub(super) fn condition(reader: &mut Reader<'_>, text: At<String>) -> Condition {
    let belongs = |letter: char| letter.is_alphanumeric() || letter == '.' || letter == '_';
    let head = text.split(|letter| !belongs(letter)).next().unwrap_or("");
    let at = At::new(head.to_owned(), reader.part(&text, 0..head.len()));
    let path = if head.contains('.') {
        path(reader, &at)
    } else {
        None
    };
    Condition { text, path }
}
