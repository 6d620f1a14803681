//! Headers of all messages, and replies without a result.

use serde_json::{Value, json};

use super::asyncapi::BINDING;

/// Replies common to all services: `refusal` and `unavailable`.
pub(super) fn refusals() -> [(String, Value); 2] {
    let answer = |kind: &str, more: Value| {
        let mut message = json!({
            "name": kind,
            "headers": { "$ref": format!("#/components/schemas/{kind}Headers") },
            "bindings": { "amqp": { "messageType": kind, "bindingVersion": BINDING } },
        });
        if let (Value::Object(message), Value::Object(more)) = (&mut message, more) {
            message.extend(more);
        }
        (kind.to_owned(), message)
    };
    let words = json!({ "type": "string", "description": "Text of the fault." });
    [
        answer(
            "refusal",
            json!({ "contentType": "text/plain", "payload": words }),
        ),
        answer(
            "unavailable",
            json!({ "description": "No server is available, or the request is unknown. The payload is empty." }),
        ),
    ]
}

/// The headers specified in `docs/wire.md`.
pub(super) fn headers() -> [(&'static str, Value); 5] {
    let text = |doc: &str| json!({ "type": "string", "description": doc });
    let whole = |doc: &str| json!({ "type": "integer", "description": doc });
    let source = text("Component that sent the message.");
    let incarnation = whole("Incarnation of the sender's process; increases with every restart.");
    [
        (
            "topicHeaders",
            json!({ "type": "object", "properties": {
                "source": source,
                "incarnation": incarnation,
                "sequence": whole("Sequence number among the messages of this publisher, from 1 without gaps."),
                "stamp": whole("Time of sending, in nanoseconds."),
                "clock": text("Clock of the time stamp, for example `wall:rover1`."),
                "traceparent": text("Trace of the message, in the W3C format."),
            } }),
        ),
        (
            "requestHeaders",
            json!({ "type": "object", "required": ["timeout"], "properties": {
                "source": source,
                "incarnation": incarnation,
                "timeout": whole("Time limit of the call, in nanoseconds."),
                "deadline": whole("Deadline of the call, in nanoseconds of Unix time."),
                "callback": text("Address at which the caller serves later callbacks."),
            } }),
        ),
        ("resultHeaders", json!({ "type": "object" })),
        (
            "refusalHeaders",
            json!({ "type": "object", "properties": { "code": text("Code of the fault.") } }),
        ),
        (
            "unavailableHeaders",
            json!({ "type": "object", "properties": {
                "code": text("`STOPPED`, if the component behind the provider does not run."),
            } }),
        ),
    ]
}
