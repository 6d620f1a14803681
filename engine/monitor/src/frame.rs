//! Frames: what is new for a tab since its last frame, as JSON.

use std::borrow::Cow;
use std::fmt::Write;
use std::sync::Arc;
use std::time::{Duration, Instant};

use asmotion_component::Time;

use crate::desk::Desk;
use crate::feed::Feed;
use crate::log_entry::LogEntry;
use crate::output_slot::OutputSummary;
use crate::rendering::quoted;
use crate::ring::Ring;
use crate::subscriptions::{Cursors, FoundCursors, Subscriptions};
use crate::ticker::{Shared, interval_number};
use crate::under_way::UnderWay;

/// Interval between summaries of the outputs.
const SUMMARY: Duration = Duration::from_millis(250);
/// Interval after which a frame is sent although nothing is new, which tells a silent system from a broken connection.
const HEARTBEAT: Duration = Duration::from_millis(500);

/// The parts of frames that tabs share in a tick: each is written once.
#[derive(Default)]
pub(crate) struct SharedFrames {
    now: Option<Instant>,
    /// The members of all frames.
    common: Option<Arc<str>>,
    news: Vec<SharedNews>,
}

/// What is new for tabs that have subscribed to the same and have seen the same.
struct SharedNews {
    /// The outputs whose samples are sent, and whether all of them are.
    outputs: Vec<(Arc<str>, bool)>,
    before: Cursors,
    after: Cursors,
    /// Members of a frame, each after a comma; empty if nothing is new.
    json: Arc<str>,
}

impl Shared for SharedFrames {
    fn begin(&mut self, now: Instant) {
        self.now = Some(now);
        self.common = None;
        self.news.clear();
    }
}

impl SharedFrames {
    fn now(&self) -> Instant {
        self.now.unwrap_or_else(Instant::now)
    }

    /// What is new for a tab.
    fn news(&mut self, subscriptions: &mut Subscriptions, feed: &Feed) -> Arc<str> {
        let is_same = |it: &&SharedNews| {
            let outputs = subscriptions.samples.iter();
            let outputs = outputs.map(|it| (&it.name, it.every));
            let known = it.outputs.iter().map(|(name, every)| (name, *every));
            it.before == subscriptions.seen && known.eq(outputs)
        };
        if let Some(known) = self.news.iter().find(is_same) {
            subscriptions.seen.clone_from(&known.after);
            return Arc::clone(&known.json);
        }
        let before = subscriptions.seen.clone();
        let mut parts = String::new();
        samples(subscriptions, feed, &mut parts);
        batches(subscriptions, feed, &mut parts);
        rings(&mut subscriptions.seen, feed, &mut parts);
        outputs(&mut subscriptions.seen, feed, self.now(), &mut parts);
        let json: Arc<str> = parts.into();
        let outputs = subscriptions.samples.iter();
        self.news.push(SharedNews {
            outputs: outputs.map(|it| (Arc::clone(&it.name), it.every)).collect(),
            before,
            after: subscriptions.seen.clone(),
            json: Arc::clone(&json),
        });
        json
    }

    /// The members of all frames, each after a comma.
    fn common(&mut self, feed: &Feed) -> Arc<str> {
        let now = self.now();
        let common = self.common.get_or_insert_with(|| {
            let (time, lost, end) = {
                let state = feed.state();
                (state.time, state.lost, state.end.clone())
            };
            let end = end.map_or_else(|| "null".to_owned(), |end| quoted(&end));
            let (t, wall, links) = (
                time.seconds(),
                feed.milliseconds(now),
                broken_links(feed, now),
            );
            let common =
                format!(",\"t\":{t},\"wall\":{wall:.1},\"lost\":{lost},\"end\":{end}{links}");
            common.into()
        });
        Arc::clone(common)
    }
}

/// Composes the frames of a tab.
#[derive(Default)]
pub(crate) struct FrameWriter {
    /// Number of the last frame.
    seq: u64,
    last: Option<Instant>,
    under_way: UnderWay,
}

impl FrameWriter {
    /// Returns whether the tab takes another frame.
    pub(crate) fn has_room(&self) -> bool {
        self.under_way.has_room()
    }

    /// The tab has drawn a frame.
    pub(crate) fn acknowledge(&mut self, seq: u64) {
        self.under_way.acknowledge(seq.min(self.seq));
    }

    /// The next frame; `None` if nothing is new.
    pub(crate) fn next(
        &mut self,
        subscriptions: &mut Subscriptions,
        (feed, shared): (&Feed, &mut SharedFrames),
        (desk, client): (&Desk, u64),
    ) -> Option<String> {
        let now = shared.now();
        let news = shared.news(subscriptions, feed);
        if news.is_empty() && !self.is_heartbeat_due(now) {
            return None;
        }
        let control = control(desk, client);
        let common = shared.common(feed);
        Some(self.frame(now, &control, [&common, &news]))
    }

    /// The next frame of a run that is over, which only tells that the connection is alive; `None` before it is due.
    pub(crate) fn heartbeat(&mut self, end: Time, shared: &SharedFrames) -> Option<String> {
        let now = shared.now();
        if !self.is_heartbeat_due(now) {
            return None;
        }
        let t = end.seconds();
        let common = format!(",\"t\":{t},\"wall\":0,\"lost\":0,\"end\":null");
        Some(self.frame(now, "\"view\"", [&common, ""]))
    }

    fn is_heartbeat_due(&self, now: Instant) -> bool {
        self.last
            .is_none_or(|last| now.duration_since(last) >= HEARTBEAT)
    }

    fn frame(&mut self, now: Instant, control: &str, [common, news]: [&str; 2]) -> String {
        self.last = Some(now);
        self.seq += 1;
        let (seq, ack) = (self.seq, self.under_way.ask(self.seq, now));
        let mut frame = String::with_capacity(128 + common.len() + news.len());
        append(
            &mut frame,
            format_args!("{{\"type\":\"frame\",\"seq\":{seq},\"ack\":{ack},\"control\":{control}"),
        );
        frame.push_str(common);
        frame.push_str(news);
        frame.push('}');
        frame
    }
}

/// The member of a frame that says what a tab may do.
fn control(desk: &Desk, client: u64) -> Cow<'static, str> {
    if !desk.is_open() {
        return "\"view\"".into();
    }
    match desk.armed_for(client) {
        Some(left) => format!("{{\"armed_s\":{}}}", left.as_secs()).into(),
        None if desk.is_held_by_other(client) => "\"held\"".into(),
        None => "\"free\"".into(),
    }
}

/// The newest samples of outputs that have written.
fn samples(subscriptions: &mut Subscriptions, feed: &Feed, parts: &mut String) {
    let mut members = Members::new("samples");
    let cursors = &mut subscriptions.seen.samples;
    let subscribed = subscriptions.samples.iter_mut().zip(cursors);
    for (subscription, sent) in subscribed.filter(|(it, _)| !it.every) {
        let slot = subscription.find(feed);
        let Some(newest) = slot.and_then(|slot| slot.newer_than(*sent)) else {
            continue;
        };
        *sent = newest.number;
        members.add(
            parts,
            format_args!(
                "{}:{{\"n\":{},\"t\":{},\"type\":{},\"data\":{}}}",
                quoted(&subscription.name),
                newest.number,
                newest.at.seconds(),
                quoted(newest.kind()),
                newest.json(),
            ),
        );
    }
    members.end(parts);
}

/// All new samples of the outputs of which the tab receives every one: the number of the last, and pairs of time and content.
fn batches(subscriptions: &mut Subscriptions, feed: &Feed, parts: &mut String) {
    let mut members = Members::new("batches");
    let cursors = &mut subscriptions.seen.samples;
    let subscribed = subscriptions.samples.iter_mut().zip(cursors);
    for (subscription, sent) in subscribed.filter(|(it, _)| it.every) {
        let slot = subscription.find(feed);
        let Some(batch) = slot.map(|slot| slot.batch_since(*sent)) else {
            continue;
        };
        let Some(last) = batch.samples.last() else {
            continue;
        };
        *sent = last.number;
        members.add(
            parts,
            format_args!(
                "{}:{{\"n\":{},\"missed\":{},\"type\":{},\"samples\":[",
                quoted(&subscription.name),
                last.number,
                batch.missed,
                quoted(last.kind()),
            ),
        );
        for (index, sample) in batch.samples.iter().enumerate() {
            let comma = if index == 0 { "" } else { "," };
            let (t, json) = (sample.at.seconds(), sample.json());
            append(parts, format_args!("{comma}[{t},{json}]"));
        }
        parts.push_str("]}");
    }
    members.end(parts);
}

/// An object in a frame, which is left out without members.
struct Members {
    name: &'static str,
    count: usize,
}

impl Members {
    fn new(name: &'static str) -> Self {
        Self { name, count: 0 }
    }

    fn add(&mut self, parts: &mut String, member: std::fmt::Arguments<'_>) {
        if self.count == 0 {
            append(parts, format_args!(",\"{}\":{{", self.name));
        } else {
            parts.push(',');
        }
        self.count += 1;
        append(parts, member);
    }

    fn end(self, parts: &mut String) {
        if self.count > 0 {
            parts.push('}');
        }
    }
}

fn rings(seen: &mut Cursors, feed: &Feed, parts: &mut String) {
    let state = feed.state();
    if std::mem::take(&mut seen.needs_states) {
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
    if let Some(cursor) = &mut seen.steps {
        let reading = state.steps.since(*cursor);
        list(parts, "steps", reading.entries.map(|it| &**it));
        missed(parts, "steps", reading.missed);
        *cursor = reading.next;
    }
    if let Some(found) = &mut seen.found {
        entries_found(found, &state.log, &state.calls, parts);
    } else {
        let rings = [
            ("log", &state.log, &mut seen.log),
            ("calls", &state.calls, &mut seen.calls),
        ];
        for (name, ring, cursor) in rings {
            if let Some(cursor) = cursor {
                let reading = ring.since(*cursor);
                list(parts, name, reading.entries.map(|it| &*it.json));
                missed(parts, name, reading.missed);
                *cursor = reading.next;
            }
        }
    }
    if let (Some(sent), Some(presence)) = (&mut seen.components, &state.presence)
        && presence.number > *sent
    {
        *sent = presence.number;
        append(parts, format_args!(",\"components\":{}", presence.json));
    }
}

/// The entries that a tab has asked for, of all that are kept at first; an empty list then says that there are none.
fn entries_found(
    found: &mut FoundCursors,
    log: &Ring<LogEntry>,
    calls: &Ring<LogEntry>,
    parts: &mut String,
) {
    let (notes, calls) = (log.since(found.log), calls.since(found.calls));
    let takes = |entry: &&LogEntry| found.filter.takes(entry);
    let (next, lost) = ((notes.next, calls.next), notes.missed + calls.missed);
    let taken = notes.entries.chain(calls.entries).filter(takes);
    let taken: Vec<&str> = taken.map(|it| &*it.json).collect();
    if !taken.is_empty() || found.is_new {
        let (number, entries) = (found.filter.number, taken.join(","));
        append(
            parts,
            format_args!(",\"found\":{{\"filter\":{number},\"entries\":[{entries}]}}"),
        );
    }
    // what was displaced before the tab asked is no loss
    missed(parts, "log", if found.is_new { 0 } else { lost });
    (found.log, found.calls) = next;
    found.is_new = false;
}

fn outputs(seen: &mut Cursors, feed: &Feed, now: Instant, parts: &mut String) {
    let interval = interval_number(SUMMARY, now);
    if let Some(sent) = &mut seen.outputs
        && *sent != interval
    {
        *sent = interval;
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
        let bytes = it
            .bytes
            .map_or_else(|| "null".to_owned(), |bytes| bytes.to_string());
        format!(
            "{{\"name\":{},\"type\":{},\"topic\":{topic},\"n\":{},\"hz\":{rate},\"bytes\":{bytes},\"age_ms\":{},\"stale\":{}}}",
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

fn list<'a>(parts: &mut String, name: &str, entries: impl ExactSizeIterator<Item = &'a str>) {
    if entries.len() == 0 {
        return;
    }
    append(parts, format_args!(",\"{name}\":["));
    for (index, entry) in entries.enumerate() {
        let comma = if index == 0 { "" } else { "," };
        append(parts, format_args!("{comma}{entry}"));
    }
    parts.push(']');
}

/// The number of entries that a tab has missed.
fn missed(parts: &mut String, name: &str, count: u64) {
    if count > 0 {
        append(parts, format_args!(",\"missed_{name}\":{count}"));
    }
}

fn append(parts: &mut String, text: std::fmt::Arguments<'_>) {
    // writing to a string does not fail
    let _ = parts.write_fmt(text);
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::subscriptions::WantedStreams;
    use asmotion_datum::Datum;
    use asmotion_runtime::{Event, Observer};

    fn publish(feed: &mut Feed, value: i64) {
        let event = Event::Published {
            component: "Driver",
            port: "odom",
            topic: None,
            sequence: 1,
            sample: &Datum::Int(value),
        };
        feed.observe(Time::ZERO, &event);
    }

    #[test]
    fn tabs_that_have_seen_the_same_share_what_is_new_and_others_do_not() {
        let mut feed = Feed::default();
        publish(&mut feed, 1);
        let subscribed = |streams: &[&str]| {
            let mut subscriptions = Subscriptions::default();
            let streams: Vec<String> = streams.iter().map(|it| (*it).to_owned()).collect();
            let wanted = WantedStreams {
                streams: &streams,
                ..WantedStreams::default()
            };
            subscriptions.replace(wanted, &feed, 10).unwrap();
            subscriptions
        };
        let mut one = subscribed(&["log", "Driver.odom"]);
        let mut two = subscribed(&["log", "Driver.odom"]);
        let mut other = subscribed(&["log", "Laser.scan"]);
        let mut shared = SharedFrames::default();
        shared.begin(Instant::now());
        let first = shared.news(&mut one, &feed);
        assert!(Arc::ptr_eq(&first, &shared.news(&mut two, &feed)));
        assert!(first.contains("\"data\":1"), "{first}");
        assert_eq!(&*shared.news(&mut other, &feed), "");
        // one has missed a tick
        publish(&mut feed, 2);
        shared.begin(Instant::now());
        shared.news(&mut one, &feed);
        publish(&mut feed, 3);
        shared.begin(Instant::now());
        let news = [&mut one, &mut two].map(|it| shared.news(it, &feed));
        assert!(!Arc::ptr_eq(&news[0], &news[1]));
        assert!(news.iter().all(|it| it.contains("\"data\":3")), "{news:?}");
        assert!(one.seen == two.seen);
    }
}
