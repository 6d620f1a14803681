//! JSON Schemas of the records in a recording.

use asmotion_viewer_encoding::ChannelSchema;
use serde_json::{Value, json};

fn text() -> Value {
    json!({ "type": "string" })
}

fn integer() -> Value {
    json!({ "type": "integer" })
}

fn list(of: Value) -> Value {
    json!({ "type": "array", "items": of })
}

fn texts_by_location() -> Value {
    json!({ "type": "object", "additionalProperties": text() })
}

fn object(properties: Value) -> Value {
    json!({ "type": "object", "properties": properties })
}

/// The schema of a step of a coordinator.
pub(super) fn step() -> ChannelSchema {
    let origin =
        object(json!({ "kind": text(), "time_ns": integer(), "frame": texts_by_location() }));
    let source = object(json!({ "path": text(), "hash": text() }));
    let begin = object(json!({
        "from": origin, "agents": list(text()), "sources": list(source), "state": texts_by_location(),
        "watch": { "type": "object" },
    }));
    let message = object(json!({
        "kind": text(), "from": text(), "to": text(), "operation": text(), "data": text(),
        "call": integer(), "fault": text(), "is_down": { "type": "boolean" },
    }));
    let read = object(json!({ "location": text(), "value": text() }));
    let choice = object(json!({ "index": integer(), "of": integer() }));
    let update =
        object(json!({ "location": text(), "before": text(), "after": text(), "place": text() }));
    let replaced = object(
        json!({ "rule": text(), "choices": list(choice.clone()), "updates": list(update.clone()) }),
    );
    let schema = object(json!({
        "specification": text(), "number": integer(), "time_ns": integer(), "cause": list(text()),
        "begins": list(begin), "messages": list(message), "frame": texts_by_location(),
        "read": list(read), "choices": list(choice), "updates": list(update),
        "extended": list(text()), "sent": list(text()), "fault": text(),
        "violations": list(json!({ "type": "object" })), "replaced": replaced, "frame_hash": text(),
        "state_hash": text(), "previous": text(), "hash": text(),
    }));
    ChannelSchema::Json("asmotion.Step".to_owned(), schema.to_string())
}

/// The schema of a call and its end.
pub(super) fn call() -> ChannelSchema {
    let schema = object(json!({
        "phase": { "enum": ["call", "reply", "fault"] }, "call": integer(), "attempt": integer(),
        "duration_s": { "type": "number" }, "argument": {}, "result": {}, "error": text(),
    }));
    ChannelSchema::Json("asmotion.Call".to_owned(), schema.to_string())
}

/// The schema of a reply of a provider.
pub(super) fn answer() -> ChannelSchema {
    let schema = object(json!({ "caller": text(), "result": {}, "error": text() }));
    ChannelSchema::Json("asmotion.Answer".to_owned(), schema.to_string())
}

/// The schema of a mark, by which readers find a place in the recording.
pub(super) fn mark() -> ChannelSchema {
    let schema = object(json!({
        "kind": text(), "component": text(), "step": integer(), "text": text(),
    }));
    ChannelSchema::Json("asmotion.Mark".to_owned(), schema.to_string())
}

/// The schema of a command from outside, and of its outcome.
pub(super) fn command() -> ChannelSchema {
    let schema = object(json!({
        "number": integer(), "client": text(), "tab": integer(), "login": { "enum": ["cookie", "token"] }, "text": text(),
        "outcome": { "enum": ["asked", "done", "refused", "unknown"] }, "reason": text(), "left_out": integer(),
    }));
    ChannelSchema::Json("asmotion.Command".to_owned(), schema.to_string())
}

/// The schema of the numbers of messages that wait.
pub(super) fn queues() -> ChannelSchema {
    let waiting = json!({ "type": "object", "additionalProperties": integer() });
    let schema = object(json!({ "waiting": waiting }));
    ChannelSchema::Json("asmotion.Queues".to_owned(), schema.to_string())
}

/// The schema of an event.
pub(super) fn event() -> ChannelSchema {
    let schema = object(json!({
        "kind": text(), "component": text(), "text": text(), "from": text(), "to": text(),
        "port": text(), "property": text(), "count": integer(), "value": {}, "data": {},
        "took_s": { "type": "number" }, "deadline_s": { "type": "number" },
    }));
    ChannelSchema::Json("asmotion.Event".to_owned(), schema.to_string())
}
