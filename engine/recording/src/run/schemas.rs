//! JSON Schemas of the records in a recording.

use std::sync::Arc;

use asmotion_datum::Schema;
use asmotion_datum::json_schema::SchemaDefinitions;
use serde_json::{Value, json};

use super::queue::ChannelSchema;
use super::ros_type::RosType;

/// The schema of messages of a type: that of ROS 2 if there is one, otherwise one of JSON; of any object if the type is unknown.
pub(super) fn of_messages(name: &str, schema: Option<&Schema>) -> ChannelSchema {
    if let Some(of) = schema.and_then(RosType::of) {
        return ChannelSchema::Ros(Arc::new(of));
    }
    let Some(schema) = schema else {
        let name = if name.is_empty() {
            "asmotion.Message"
        } else {
            name
        };
        return ChannelSchema::Json(name.to_owned(), json!({ "type": "object" }).to_string());
    };
    let name = match (&*schema.name, name) {
        ("", "") => "asmotion.Message",
        ("", name) => name,
        (known, _) => known,
    };
    let mut definitions = SchemaDefinitions::at("#/$defs");
    let root = definitions.schema(schema);
    let root = resolved(root, &definitions.into_value());
    ChannelSchema::Json(name.to_owned(), root.to_string())
}

/// Puts the root definition in the place of the reference to it: readers expect an object with properties.
fn resolved(root: Value, definitions: &Value) -> Value {
    let reference = root.get("$ref").and_then(Value::as_str);
    let key = reference.and_then(|path| path.strip_prefix("#/$defs/"));
    let mut root = match key.and_then(|key| definitions.get(key)) {
        Some(definition) => definition.clone(),
        None => root,
    };
    if let Value::Object(members) = &mut root {
        members.insert("$defs".to_owned(), definitions.clone());
        // a reader that wants an object gets one, whatever is in it
        members.entry("type").or_insert_with(|| "object".into());
    }
    root
}

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

/// The schema of an event.
pub(super) fn event() -> ChannelSchema {
    let schema = object(json!({
        "kind": text(), "component": text(), "text": text(), "from": text(), "to": text(),
        "port": text(), "property": text(), "count": integer(), "value": {}, "data": {},
        "took_s": { "type": "number" }, "deadline_s": { "type": "number" },
    }));
    ChannelSchema::Json("asmotion.Event".to_owned(), schema.to_string())
}
