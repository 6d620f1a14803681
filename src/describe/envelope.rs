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
    let words = json!({ "type": "string", "description": "the words of a fault" });
    [
        answer(
            "refusal",
            json!({ "contentType": "text/plain", "payload": words }),
        ),
        answer(
            "unavailable",
            json!({ "description": "No server is available, or the request is unknown; without content." }),
        ),
    ]
}

/// The headers specified in `docs/wire.md`.
pub(super) fn headers() -> [(&'static str, Value); 5] {
    let text = |doc: &str| json!({ "type": "string", "description": doc });
    let whole = |doc: &str| json!({ "type": "integer", "description": doc });
    let source = text("the component that sent it");
    let incarnation = whole("which life of its process; grows with every restart");
    [
        (
            "topicHeaders",
            json!({ "type": "object", "properties": {
                "source": source,
                "incarnation": incarnation,
                "sequence": whole("its number among this publisher's messages, from 1 without gaps"),
                "stamp": whole("when it was sent, in nanoseconds"),
                "clock": text("of which clock: `wall:rover1`"),
                "traceparent": text("the trace it belongs to, as W3C writes it"),
            } }),
        ),
        (
            "requestHeaders",
            json!({ "type": "object", "required": ["timeout"], "properties": {
                "source": source,
                "incarnation": incarnation,
                "timeout": whole("how many nanoseconds the caller gives it"),
                "deadline": whole("when the caller gives up, in nanoseconds of Unix time"),
                "callback": text("the address where the caller serves what comes later"),
            } }),
        ),
        ("resultHeaders", json!({ "type": "object" })),
        (
            "refusalHeaders",
            json!({ "type": "object", "properties": { "code": text("the code of the fault") } }),
        ),
        ("unavailableHeaders", json!({ "type": "object" })),
    ]
}
