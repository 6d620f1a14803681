//! The messages of channels that are no samples: frames, steps, states and the log, as JSON.

use std::sync::{Arc, LazyLock};

use asmotion_component::Time;
use asmotion_coordinator::StepRecord;
use asmotion_datum::Datum;
use asmotion_viewer_encoding::ChannelSchema;
use serde::Deserialize;
use serde_json::{Value, json};

use crate::feed::time;
use crate::specification_state::SpecificationState;

/// A schema that all viewers share.
type SharedSchema = LazyLock<Arc<ChannelSchema>>;

fn schema(name: &str, properties: Value) -> Arc<ChannelSchema> {
    let schema = json!({ "title": name, "type": "object", "properties": properties });
    Arc::new(ChannelSchema::Json(name.to_owned(), schema.to_string()))
}

fn numbers(names: &[&str]) -> Value {
    let members = names
        .iter()
        .map(|name| ((*name).to_owned(), json!({ "type": "number" })));
    json!({ "type": "object", "properties": members.collect::<serde_json::Map<_, _>>() })
}

fn objects(properties: Value) -> Value {
    json!({ "type": "array", "items": { "type": "object", "properties": properties } })
}

/// The schema of log entries, which viewers know by its name.
pub(super) fn log_schema() -> Arc<ChannelSchema> {
    static SCHEMA: SharedSchema = LazyLock::new(|| {
        let text = json!({ "type": "string" });
        schema(
            "foxglove.Log",
            json!({
                "timestamp": timestamp_schema(), "level": { "type": "integer" }, "message": text, "name": text,
                "file": text, "line": { "type": "integer" },
            }),
        )
    });
    Arc::clone(&SCHEMA)
}

/// The schema of the places of frames, which viewers know by its name.
pub(super) fn frame_schema() -> Arc<ChannelSchema> {
    static SCHEMA: SharedSchema = LazyLock::new(|| {
        let text = json!({ "type": "string" });
        schema(
            "foxglove.FrameTransform",
            json!({
                "timestamp": timestamp_schema(), "parent_frame_id": text, "child_frame_id": text,
                "translation": numbers(&["x", "y", "z"]), "rotation": numbers(&["x", "y", "z", "w"]),
            }),
        )
    });
    Arc::clone(&SCHEMA)
}

/// The schema of steps: a part of that of recorded steps.
pub(super) fn step_schema() -> Arc<ChannelSchema> {
    static SCHEMA: SharedSchema = LazyLock::new(|| {
        let (text, integer) = (json!({ "type": "string" }), json!({ "type": "integer" }));
        let update = json!({ "location": text, "before": text, "after": text, "place": text });
        schema(
            "asmotion.Step",
            json!({
                "specification": text, "number": integer, "time_ns": integer,
                "read": objects(json!({ "location": text, "value": text })),
                "choices": objects(json!({ "index": integer, "of": integer })),
                "updates": objects(update),
                "replaced": { "type": "object", "properties": { "rule": text } },
            }),
        )
    });
    Arc::clone(&SCHEMA)
}

/// The schema of states.
pub(super) fn state_schema() -> Arc<ChannelSchema> {
    static SCHEMA: SharedSchema = LazyLock::new(|| {
        let text = json!({ "type": "string" });
        schema(
            "asmotion.State",
            json!({
                "number": { "type": "integer" }, "time_ns": { "type": "integer" }, "control_state": text,
                "values": { "type": "object", "additionalProperties": text },
            }),
        )
    });
    Arc::clone(&SCHEMA)
}

fn timestamp_schema() -> Value {
    let integer = json!({ "type": "integer" });
    json!({ "type": "object", "title": "time", "properties": { "sec": integer, "nsec": integer } })
}

fn timestamp(at: Time) -> Value {
    let nanos = at.nanos().max(0);
    json!({ "sec": nanos / 1_000_000_000, "nsec": nanos % 1_000_000_000 })
}

/// An entry of the feed's log.
#[derive(Deserialize)]
struct LoggedEntry {
    t: f64,
    level: String,
    kind: String,
    component: String,
    text: String,
}

/// A log entry, with its time; calls and replies, of which there can be many, have the lowest level.
pub(super) fn log(entry: &str, is_call: bool) -> Option<(Time, Vec<u8>)> {
    let entry: LoggedEntry = serde_json::from_str(entry).ok()?;
    let level = match &*entry.level {
        "info" if is_call => 1,
        "warning" => 3,
        "error" => 4,
        _ => 2,
    };
    let at = time(entry.t);
    let name = if entry.component.is_empty() {
        &entry.kind
    } else {
        &entry.component
    };
    let message = json!({
        "timestamp": timestamp(at), "level": level, "message": format!("{}: {}", entry.kind, entry.text), "name": name,
        "file": "", "line": 0,
    });
    Some((at, message.to_string().into_bytes()))
}

/// An entry of the feed's steps.
#[derive(Deserialize)]
struct ReportedStep {
    t: f64,
    step: StepRecord,
}

/// A step, with its time.
pub(super) fn step(entry: &str) -> Option<(Time, Vec<u8>)> {
    let ReportedStep { t, step } = serde_json::from_str(entry).ok()?;
    let at = time(t);
    let read = step.inputs.iter();
    let read = read.map(|(location, value)| json!({ "location": location, "value": value }));
    let choices = step.choices.iter();
    let choices = choices.map(|(index, of)| json!({ "index": index, "of": of }));
    let mut message = json!({
        "specification": step.specification, "number": step.number, "time_ns": at.nanos(),
        "read": read.collect::<Vec<_>>(), "choices": choices.collect::<Vec<_>>(), "updates": step.updates,
    });
    if let Some(rule) = step.safe_rule {
        message["replaced"] = json!({ "rule": rule });
    }
    Some((at, message.to_string().into_bytes()))
}

/// A state, with its time. `control_state` is the location of the control state.
pub(super) fn state(state: &SpecificationState, control_state: Option<&str>) -> (Time, Vec<u8>) {
    let values: serde_json::Map<String, Value> = state
        .values()
        .map(|(location, value)| (location.to_owned(), value.into()))
        .collect();
    let at = state.at();
    let control_state = control_state.and_then(|location| values.get(location));
    let mut message = json!({ "number": state.number(), "time_ns": at.nanos() });
    if let Some(control_state) = control_state {
        message["control_state"] = control_state.clone();
    }
    message["values"] = Value::Object(values);
    (at, message.to_string().into_bytes())
}

/// The place of the frame of an odometry message; `None` if it names no frames.
pub(super) fn frame(odometry: &Datum) -> Option<Vec<u8>> {
    let text = |path| Some(odometry.get(path)?.as_text()?.to_owned());
    let (parent, child) = (text("header.frame_id")?, text("child_frame_id")?);
    if parent.is_empty() || child.is_empty() {
        return None;
    }
    let integer = |path: &str| {
        let value = odometry.get(path)?;
        if let Datum::Int(value) = *value {
            return Some(value);
        }
        None
    };
    let number = |path: String| {
        let value = odometry.get(&path)?;
        if let Datum::Float(value) = *value {
            return Some(value);
        }
        integer(&path).map(|value| value as f64)
    };
    let vector = |path: &str, names: &[&str]| {
        let members = names.iter().map(|name| {
            let value = number(format!("{path}.{name}"))?;
            Some(((*name).to_owned(), value.into()))
        });
        members.collect::<Option<serde_json::Map<String, Value>>>()
    };
    let message = json!({
        "timestamp": { "sec": integer("header.stamp.sec")?, "nsec": integer("header.stamp.nanosec")? },
        "parent_frame_id": parent, "child_frame_id": child,
        "translation": vector("pose.pose.position", &["x", "y", "z"])?,
        "rotation": vector("pose.pose.orientation", &["x", "y", "z", "w"])?,
    });
    Some(message.to_string().into_bytes())
}
