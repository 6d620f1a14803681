//! Frames: what is new for a tab since its last frame, as JSON.

use std::fmt::Write;
use std::sync::Arc;
use std::time::{Duration, Instant};

use asmotion_component::Time;

use crate::desk::Desk;
use crate::feed::Feed;
use crate::output_slot::OutputSummary;
use crate::rendering::quoted;
use crate::subscriptions::Subscriptions;

/// Interval between summaries of the outputs.
const SUMMARY: Duration = Duration::from_millis(250);
/// Interval after which a frame is sent although nothing is new, which tells a silent system from a broken connection.
const HEARTBEAT: Duration = Duration::from_millis(500);

/// Composes the frames of a tab.
pub(crate) struct FrameWriter {
    /// Number of the last frame.
    pub seq: u64,
    last: Option<Instant>,
    last_summary: Option<Instant>,
}

impl FrameWriter {
    pub(crate) fn new() -> Self {
        Self {
            seq: 0,
            last: None,
            last_summary: None,
        }
    }

    /// The next frame; `None` if nothing is new.
    pub(crate) fn next(
        &mut self,
        subscriptions: &mut Subscriptions,
        feed: &Feed,
        (desk, client): (&Desk, u64),
    ) -> Option<String> {
        let now = Instant::now();
        let mut parts = String::new();
        self.samples(subscriptions, feed, &mut parts);
        self.rings(subscriptions, feed, &mut parts);
        self.outputs(subscriptions, feed, now, &mut parts);
        let links = broken_links(feed, now);
        let is_due = |last: Instant| now.duration_since(last) >= HEARTBEAT;
        if parts.is_empty() && !self.last.is_none_or(is_due) {
            return None;
        }
        self.last = Some(now);
        self.seq += 1;
        let (time, lost, end) = {
            let state = feed.state();
            (state.time, state.lost, state.end.clone())
        };
        let control = match (desk.is_open(), desk.armed_for(client)) {
            (false, _) => "\"view\"".to_owned(),
            (true, Some(left)) => format!("{{\"armed_s\":{}}}", left.as_secs()),
            (true, None) if desk.is_held_by_other(client) => "\"held\"".to_owned(),
            (true, None) => "\"free\"".to_owned(),
        };
        let end = end.map_or_else(|| "null".to_owned(), |end| quoted(&end));
        let (seq, t, wall) = (self.seq, time.seconds(), feed.milliseconds(now));
        Some(format!(
            "{{\"type\":\"frame\",\"seq\":{seq},\"t\":{t},\"wall\":{wall:.1},\"lost\":{lost},\"control\":{control},\"end\":{end}{links}{parts}}}"
        ))
    }

    /// The next frame of a run that is over, which only tells that the connection is alive; `None` before it is due.
    pub(crate) fn heartbeat(&mut self, end: Time) -> Option<String> {
        let now = Instant::now();
        let is_due = |last: Instant| now.duration_since(last) >= HEARTBEAT;
        if !self.last.is_none_or(is_due) {
            return None;
        }
        self.last = Some(now);
        self.seq += 1;
        let (seq, t) = (self.seq, end.seconds());
        Some(format!(
            "{{\"type\":\"frame\",\"seq\":{seq},\"t\":{t},\"wall\":0,\"lost\":0,\"control\":\"view\",\"end\":null}}"
        ))
    }

    fn samples(&self, subscriptions: &mut Subscriptions, feed: &Feed, parts: &mut String) {
        let mut samples = Vec::new();
        for subscription in &mut subscriptions.samples {
            if subscription.slot.is_none() {
                subscription.slot = feed.output(&subscription.name);
            }
            let slot = subscription.slot.as_ref();
            let Some(newest) = slot.and_then(|slot| slot.newer_than(subscription.sent)) else {
                continue;
            };
            subscription.sent = newest.number;
            samples.push(format!(
                "{}:{{\"n\":{},\"t\":{},\"wall\":{:.1},\"type\":{},\"data\":{}}}",
                quoted(&subscription.name),
                newest.number,
                newest.at.seconds(),
                feed.milliseconds(newest.arrived),
                quoted(newest.kind()),
                newest.json(),
            ));
        }
        if !samples.is_empty() {
            append(
                parts,
                format_args!(",\"samples\":{{{}}}", samples.join(",")),
            );
        }
    }

    fn rings(&self, subscriptions: &mut Subscriptions, feed: &Feed, parts: &mut String) {
        let state = feed.state();
        if std::mem::take(&mut subscriptions.needs_states) {
            let states = serde_json::to_string(&state.specifications);
            append(
                parts,
                format_args!(",\"states\":{}", states.unwrap_or_default()),
            );
            let rings = state.history.values();
            let history: Vec<&str> = rings
                .flat_map(|ring| ring.since(0).entries.map(|it| &**it))
                .collect();
            append(parts, format_args!(",\"history\":[{}]", history.join(",")));
        }
        let rings = [
            ("steps", &state.steps, &mut subscriptions.steps),
            ("log", &state.log, &mut subscriptions.log),
            ("calls", &state.calls, &mut subscriptions.calls),
        ];
        for (name, ring, cursor) in rings {
            if let Some(cursor) = cursor {
                let reading = ring.since(*cursor);
                list(parts, name, reading.entries, reading.missed);
                *cursor = reading.next;
            }
        }
        if let (Some(sent), Some(presence)) = (&mut subscriptions.components, &state.presence)
            && presence.number > *sent
        {
            *sent = presence.number;
            append(parts, format_args!(",\"components\":{}", presence.json));
        }
    }

    fn outputs(
        &mut self,
        subscriptions: &Subscriptions,
        feed: &Feed,
        now: Instant,
        parts: &mut String,
    ) {
        let is_due = |last: Instant| now.duration_since(last) >= SUMMARY;
        if !subscriptions.outputs || !self.last_summary.is_none_or(is_due) {
            return;
        }
        self.last_summary = Some(now);
        append(parts, format_args!(",\"outputs\":{}", outputs_json(feed)));
    }
}

/// The member of a frame with the connections over which nothing is sent; empty if there are none.
fn broken_links(feed: &Feed, now: Instant) -> String {
    let links = feed.links().iter().map(|it| it.summary(now));
    let broken: Vec<String> = links
        .filter(|it| !it.is_up())
        .map(|it| it.json().to_string())
        .collect();
    if broken.is_empty() {
        String::new()
    } else {
        format!(",\"links\":[{}]", broken.join(","))
    }
}

/// Rates and ages of all outputs as JSON.
pub(crate) fn outputs_json(feed: &Feed) -> String {
    let output = |it: &OutputSummary| {
        let topic = it
            .topic
            .as_ref()
            .map_or_else(|| "null".to_owned(), |it| quoted(it));
        let rate = it
            .rate_hz
            .map_or_else(|| "null".to_owned(), |rate| format!("{rate:.3}"));
        format!(
            "{{\"name\":{},\"type\":{},\"topic\":{topic},\"n\":{},\"hz\":{rate},\"age_ms\":{},\"stale\":{}}}",
            quoted(&it.name),
            quoted(it.kind),
            it.count,
            it.age.as_millis(),
            it.is_stale,
        )
    };
    let outputs: Vec<String> = feed.outputs().iter().map(output).collect();
    format!("[{}]", outputs.join(","))
}

fn list<'a>(
    parts: &mut String,
    name: &str,
    entries: impl ExactSizeIterator<Item = &'a Arc<str>>,
    missed: u64,
) {
    if entries.len() == 0 {
        return;
    }
    append(parts, format_args!(",\"{name}\":["));
    for (index, entry) in entries.enumerate() {
        let comma = if index == 0 { "" } else { "," };
        append(parts, format_args!("{comma}{entry}"));
    }
    append(parts, format_args!("]"));
    if missed > 0 {
        append(parts, format_args!(",\"missed_{name}\":{missed}"));
    }
}

fn append(parts: &mut String, text: std::fmt::Arguments<'_>) {
    // writing to a string does not fail
    let _ = parts.write_fmt(text);
}
