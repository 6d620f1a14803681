//! Events of a run as JSON, other than messages, calls and steps.

use asmotion_datum::{Datum, json};
use asmotion_runtime::Event;
use serde_json::{Value, json};

/// The JSON of a datum. A float that JSON lacks is a text.
pub(super) fn datum_json(datum: &Datum) -> Value {
    let text = json::encode_datum(datum);
    // what was encoded can be decoded
    text.ok()
        .and_then(|text| serde_json::from_str(&text).ok())
        .unwrap_or_default()
}

/// The record of an event; `None` for those that have channels of their own, and for cycles, which are too many.
pub(super) fn event_record(event: &Event<'_>) -> Option<Value> {
    Some(match event {
        Event::LifeCycle {
            component,
            from,
            to,
        } => json!({
            "kind": "life_cycle", "component": component, "from": from.to_string(), "to": to.to_string(),
        }),
        Event::Fault { component, fault } => {
            json!({ "kind": "fault", "component": component, "text": fault.to_string() })
        }
        Event::Overrun { component, missed } => {
            json!({ "kind": "overrun", "component": component, "count": missed })
        }
        Event::Late {
            component,
            took,
            deadline,
        } => json!({
            "kind": "late", "component": component, "took_s": took.as_secs_f64(),
            "deadline_s": deadline.as_secs_f64(),
        }),
        Event::Denied { component, denied } => {
            json!({ "kind": "denied", "component": component, "text": denied.to_string() })
        }
        Event::Dropped {
            component,
            port,
            to,
            total,
            reason,
        } => json!({
            "kind": "dropped", "component": component, "port": port, "to": to, "count": total,
            "text": reason.map(ToString::to_string),
        }),
        Event::Property {
            component,
            property,
            value,
        } => json!({
            "kind": "property", "component": component, "property": property,
            "value": datum_json(value),
        }),
        Event::Report {
            component,
            kind,
            data,
        } => match data {
            Datum::Text(text) => json!({ "kind": kind, "component": component, "text": text }),
            Datum::Null
            | Datum::Bool(_)
            | Datum::Int(_)
            | Datum::Float(_)
            | Datum::Bytes(_)
            | Datum::Numbers(_)
            | Datum::List(_)
            | Datum::Record(_) => {
                json!({ "kind": kind, "component": component, "data": datum_json(data) })
            }
        },
        Event::Lost { count } => json!({ "kind": "lost", "count": count }),
        Event::Cycle { .. }
        | Event::Published { .. }
        | Event::Injected { .. }
        | Event::Called { .. }
        | Event::Answered { .. }
        | Event::Replied { .. } => return None,
    })
}
