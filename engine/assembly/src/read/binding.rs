//! `bind.monitored` and `bind.out`.

use super::endpoint::DAY_MS;
use super::keys::{Keys, Reader};
use super::{name, setting};
use crate::At;
use crate::codes::c010::ExclusiveKeys;
use crate::finding::Findings;
use crate::model::Path;
use crate::model::binding::{Action, Argument, Bind, Call, Effect, Monitored, Out, Source};
use crate::tree::{Branch, Node, Table};
use asmotion_coordinator::Receive;

const MONITORED: &str = "{ topic = \"estop\", field = \"data\" }";
const PUBLISH: &str = "{ topic = \"command\", publish = \"on_update\" }";
const ACTION: &str = "{ call = \"planner.plan\", ok = \"PATH_OK\", event = \"ev\" }";

pub(crate) fn bind(keys: &mut Keys<'_, '_, '_>) -> Bind {
    keys.table(
        "bind",
        "`bind`",
        "{ monitored = { }, out = { } }",
        |mut keys| Bind {
            monitored: keys.named("monitored", "{ }", monitored),
            out: keys.named("out", "{ }", out),
        },
    )
    .unwrap_or_default()
}

fn monitored(reader: &mut Reader<'_>, function: &At<String>, node: &Node) -> Option<Monitored> {
    let mut keys = reader.keys_of(node, function, "a bound monitored function", MONITORED)?;
    let from = source(&mut keys);
    let receive = receive(&mut keys, function);
    let (field, map) = (path(&mut keys, "field"), path(&mut keys, "map"));
    if let (Some((first_at, _)), Some((at, _))) = (keys.entry("field"), keys.entry("map")) {
        excluded(
            &mut keys,
            ("field", first_at),
            ("map", at),
            "one field is the value",
        );
    }
    let is = match keys
        .entry("is")
        .map(|(_, node)| matches!(node.value, Branch::Text(_)))
    {
        Some(true) => keys.text("is", "\"idle\"").into_iter().collect(),
        _ => keys.texts("is", "\"idle\""),
    };
    let none = keys.node("none").cloned();
    let stale_ms = keys.whole("stale_ms", 1..=DAY_MS);
    let on_stale = keys.node("on_stale").cloned();
    if on_stale.is_some() {
        keys.need("stale_ms", "300");
    }
    let function = function.clone();
    Some(Monitored {
        function,
        from: from?,
        receive,
        field,
        map,
        is,
        none,
        stale_ms,
        on_stale,
    })
}

/// `topic = "estop"` or `service = "move.moveTo"`.
fn source(keys: &mut Keys<'_, '_, '_>) -> Option<Source> {
    let reason = "a value comes from one place";
    match keys.one_of(&["topic", "service"], "\"estop\"", reason)? {
        ("topic", topic) => Some(Source::Topic(topic)),
        (_, operation) => name::end(keys.reader, &operation).map(Source::Request),
    }
}

/// `edge = true` is a way to receive; together with `receive` it would say two things.
fn receive(keys: &mut Keys<'_, '_, '_>, function: &At<String>) -> At<Receive> {
    let edge = keys.flag("edge").filter(|edge| edge.value);
    let receive = keys.word::<Receive>("receive");
    match (edge, receive) {
        (Some(edge), Some(receive)) if receive.value != Receive::Edge => {
            let (first, second) = (("receive", receive.span), ("edge", edge.span));
            excluded(
                keys,
                first,
                second,
                "an edge is true in the step in which a message came",
            );
            At::new(Receive::Edge, edge.span)
        }
        (Some(edge), _) => At::new(Receive::Edge, edge.span),
        (None, Some(receive)) => receive,
        (None, None) => At::new(Receive::Last, function.span),
    }
}

fn excluded(
    keys: &mut Keys<'_, '_, '_>,
    (first, first_at): (&str, asmotion_diagnostics::Span),
    (second, at): (&str, asmotion_diagnostics::Span),
    reason: &'static str,
) {
    let (first, second) = (first.to_owned(), second.to_owned());
    keys.reader.report.found(ExclusiveKeys {
        first,
        first_at,
        second,
        at,
        reason,
    });
}

fn path(keys: &mut Keys<'_, '_, '_>, key: &'static str) -> Option<Path> {
    let text = keys.text(key, "\"data\"")?;
    name::path(keys.reader, &text)
}

/// `{ topic, publish }` or a table of literals.
fn out(reader: &mut Reader<'_>, function: &At<String>, node: &Node) -> Option<Out> {
    let Branch::Table(table) = &node.value else {
        reader.wrong_type(function, "a table", node, PUBLISH);
        return None;
    };
    let function = function.clone();
    if is_publish(table) {
        let mut keys = reader.keys(table, "a bound out function", node.span);
        let topic = keys.needed_text("topic", "\"command\"");
        let field = path(&mut keys, "field");
        let when = keys.word("publish");
        return Some(Out {
            function,
            effect: Effect::Publish {
                topic: topic?,
                field,
                when,
            },
        });
    }
    let literals = reader.names(table, |reader, literal, node| {
        let actions = match &node.value {
            Branch::List(items) => reader.list(items, |reader, item| action(reader, literal, item)),
            _ => action(reader, literal, node).into_iter().collect(),
        };
        Some((literal.clone(), actions))
    });
    Some(Out {
        function,
        effect: Effect::Literals(literals),
    })
}

/// Literals have tables as values; the keys of the short form have texts.
fn is_publish(table: &Table) -> bool {
    table
        .get("topic")
        .or(table.get("publish"))
        .is_some_and(|entry| match entry.node.value {
            Branch::Text(_) | Branch::Integer(_) | Branch::Float(_) | Branch::Boolean(_) => true,
            Branch::Date(_) | Branch::List(_) | Branch::Table(_) => false,
        })
}

fn action(reader: &mut Reader<'_>, literal: &At<String>, node: &Node) -> Option<Action> {
    let mut keys = reader.keys_of(node, literal, "an action", ACTION)?;
    let (call, publish) = (keys.entry("call"), keys.entry("publish"));
    match (call, publish) {
        (Some((first_at, _)), Some((at, _))) => {
            let (first, second) = (("call", first_at), ("publish", at));
            excluded(
                &mut keys,
                first,
                second,
                "an action does one thing; a list does several",
            );
            self::call(&mut keys)
        }
        (Some(_), None) => self::call(&mut keys),
        (None, Some(_)) => {
            let topic = keys.text("publish", "\"plan\"");
            keys.need("value", "\"@path\"");
            let value = argument(&mut keys, "value");
            Some(Action::Publish {
                topic: topic?,
                value: value?,
            })
        }
        (None, None) => {
            keys.need("call", "\"planner.plan\"");
            self::call(&mut keys);
            None
        }
    }
}

fn call(keys: &mut Keys<'_, '_, '_>) -> Option<Action> {
    let operation = keys.text("call", "\"planner.plan\"");
    let operation = operation.and_then(|text| name::end(keys.reader, &text));
    let with = argument(keys, "with");
    let keep = keys.text("keep", "\"path\"");
    let ok = keys.text("ok", "\"PATH_OK\"");
    let failed = keys.text("failed", "\"CALL_FAILED\"");
    let timeout = keys.text("timeout", "\"CALL_FAILED\"");
    let unavailable = keys.text("unavailable", "\"NOBODY_THERE\"");
    let event = keys.text("event", "\"ev\"");
    let reply = keys.text("reply", "\"move\"");
    let told = [&ok, &failed, &timeout, &unavailable];
    if told.iter().any(|literal| literal.is_some()) {
        keys.need("event", "\"ev\"");
    }
    let operation = operation?;
    Some(Action::Call(Box::new(Call {
        operation,
        with,
        keep,
        ok,
        failed,
        timeout,
        unavailable,
        event,
        reply,
    })))
}

fn argument(keys: &mut Keys<'_, '_, '_>, key: &'static str) -> Option<Argument> {
    let node = keys.node(key)?;
    Some(value(keys.reader, key, node))
}

/// `"@name.field"`, a record of arguments, or a plain value.
fn value(reader: &mut Reader<'_>, key: &str, node: &Node) -> Argument {
    match &node.value {
        Branch::Text(text) if text.starts_with("@@") => {
            let plain = Branch::Text(text[1..].to_owned());
            Argument::Value(Node {
                span: node.span,
                value: plain,
            })
        }
        Branch::Text(text) if text.starts_with('@') => {
            let whole = At::new(text.clone(), node.span);
            let name = At::new(text[1..].to_owned(), reader.part(&whole, 1..text.len()));
            match name::path(reader, &name) {
                Some(mut path) => {
                    let name = path.steps.remove(0);
                    Argument::Kept {
                        name,
                        path: path.steps,
                    }
                }
                None => Argument::Value(node.clone()),
            }
        }
        Branch::Table(table) => {
            let fields = table
                .entries
                .iter()
                .map(|entry| (entry.key.clone(), value(reader, &entry.key, &entry.node)));
            Argument::Record(node.span, fields.collect())
        }
        _ => {
            setting::templates(reader, key, node);
            Argument::Value(node.clone())
        }
    }
}
