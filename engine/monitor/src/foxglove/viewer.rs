//! What a viewer has subscribed to, what of it it has received, and the next batch of messages for it.

use std::collections::BTreeMap;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::{Duration, Instant};

use asmotion_component::Time;
use serde::Deserialize;
use serde_json::{Value, json};
use tokio_tungstenite::tungstenite::{Bytes, Message};

use super::channels::{ChannelSource, ViewerChannel, ViewerChannels};
use super::messages;
use crate::feed::Feed;
use crate::output_slot::{NewestSample, OutputSlot, SlotFollower};
use crate::ring::Ring;
use crate::subscriptions::RECENT;

/// Limit on batches that no pong has answered.
const MAX_UNDER_WAY: u64 = 2;
/// Time without a pong after which the viewer is taken to be gone.
const GONE: Duration = Duration::from_secs(60);
/// Interval at which new channels are searched for.
const DISCOVERY: Duration = Duration::from_millis(250);
/// Interval at which the time is sent although nothing else is new.
const CLOCK: Duration = Duration::from_millis(100);

/// Number of locations above which states are sent less often.
const LARGE: usize = 1000;
/// Interval between such states.
const LARGE_INTERVAL: Duration = Duration::from_secs(1);

/// Opcode of the binary message that has a message of a channel.
const MESSAGE_DATA: u8 = 1;
/// Opcode of the binary message that has the time.
const TIME: u8 = 2;

/// A message of a viewer. Messages and members that are not known are those of later versions.
#[derive(Deserialize)]
#[serde(tag = "op", rename_all = "camelCase")]
enum ViewerRequest {
    #[serde(rename_all = "camelCase")]
    Subscribe {
        subscriptions: Vec<WantedSubscription>,
    },
    #[serde(rename_all = "camelCase")]
    Unsubscribe { subscription_ids: Vec<u32> },
    #[serde(other)]
    Other,
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
struct WantedSubscription {
    id: u32,
    channel_id: u32,
}

/// A subscription, by the number that the viewer has given it.
struct ViewerSubscription {
    channel: u32,
    /// Numbers of the last message of each source.
    sent: BTreeMap<Arc<str>, u64>,
    /// The outputs among the sources, which keep their recent samples.
    followed: Vec<SlotFollower>,
    /// Time of the last state that was sent.
    state_sent: Option<Instant>,
}

/// A message of a channel, with the time of the run at which it came into being.
type ChannelMessage = (Time, Vec<u8>);

/// The level of a message to the user.
#[derive(Clone, Copy)]
enum StatusLevel {
    Info = 0,
    Warning = 1,
    Error = 2,
}

/// The state of a session with a viewer.
pub(super) struct Viewer {
    max_channels: usize,
    channels: ViewerChannels,
    subscriptions: BTreeMap<u32, ViewerSubscription>,
    /// Number of the last batch.
    batch: u64,
    /// Number of the last batch that a pong has answered.
    acknowledged: u64,
    /// Time of the last pong, or of the first batch without one.
    heard: Instant,
    discovered: Option<Instant>,
    /// The time that was sent last, and when.
    clock: Option<(Time, Instant)>,
    /// Whether a batch was due that had to wait for a pong.
    is_held: bool,
    /// What was said, which is not repeated.
    said: Vec<&'static str>,
    /// Number of messages that were skipped, for all viewers.
    skipped: Arc<AtomicU64>,
}

impl Viewer {
    pub(super) fn new(max_channels: usize, skipped: Arc<AtomicU64>) -> Self {
        Self {
            max_channels,
            channels: ViewerChannels::default(),
            subscriptions: BTreeMap::new(),
            batch: 0,
            acknowledged: 0,
            heard: Instant::now(),
            discovered: None,
            clock: None,
            is_held: false,
            said: Vec::new(),
            skipped,
        }
    }

    /// Takes a pong, which has the number of a batch.
    pub(super) fn acknowledge(&mut self, batch: &[u8]) {
        let Ok(batch) = batch.try_into().map(u64::from_le_bytes) else {
            return;
        };
        if (self.acknowledged..=self.batch).contains(&batch) {
            self.acknowledged = batch;
            self.heard = Instant::now();
        }
    }

    /// Returns whether the viewer has answered nothing for so long that it is taken to be gone.
    pub(super) fn is_gone(&self) -> bool {
        self.batch > self.acknowledged && self.heard.elapsed() > GONE
    }

    /// Handles a message of the viewer. Returns what the user should know.
    pub(super) fn request(&mut self, text: &str, feed: &Feed) -> Vec<Value> {
        match serde_json::from_str(text) {
            Ok(ViewerRequest::Subscribe { subscriptions }) => subscriptions
                .into_iter()
                .filter_map(|wanted| self.subscribe(&wanted, feed).err())
                .map(|problem| status(StatusLevel::Warning, &problem))
                .collect(),
            Ok(ViewerRequest::Unsubscribe { subscription_ids }) => {
                for id in subscription_ids {
                    self.subscriptions.remove(&id);
                }
                Vec::new()
            }
            Ok(ViewerRequest::Other) => {
                let text = "this server only shows the system: it offers channels and the time";
                vec![status(StatusLevel::Warning, text)]
            }
            Err(error) => {
                let text = format!("this message is not understood: {error}");
                vec![status(StatusLevel::Error, &text)]
            }
        }
    }

    fn subscribe(&mut self, wanted: &WantedSubscription, feed: &Feed) -> Result<(), String> {
        let WantedSubscription { id, channel_id } = wanted;
        let Some(channel) = self.channels.get(*channel_id) else {
            return Err(format!("there is no channel {channel_id}"));
        };
        if self.subscriptions.contains_key(id) {
            return Err(format!("subscription {id} is in use"));
        }
        let mut known = self.subscriptions.values();
        if known.any(|it| it.channel == *channel_id) {
            return Err(format!("`{}` is subscribed to already", channel.name));
        }
        if self.subscriptions.len() >= self.max_channels {
            let limit = self.max_channels;
            return Err(format!(
                "a viewer can subscribe to {limit} channels at most"
            ));
        }
        let subscription = ViewerSubscription {
            channel: *channel_id,
            sent: beginning(&channel.source, feed),
            followed: Vec::new(),
            state_sent: None,
        };
        self.subscriptions.insert(*id, subscription);
        Ok(())
    }

    /// The next messages, with a ping at the end; empty if nothing is new, or if the viewer has to answer first.
    pub(super) fn batch(&mut self, feed: &Feed) -> Vec<Message> {
        if self.batch - self.acknowledged >= MAX_UNDER_WAY {
            self.is_held = true;
            return Vec::new();
        }
        let mut batch = self.news(feed);
        let messages = self.messages(feed);
        let now = feed.state().time;
        let is_due = self.clock.is_none_or(|(sent, when)| {
            sent != now && (!messages.is_empty() || when.elapsed() >= CLOCK)
        });
        if is_due {
            // before the messages: viewers give them the time that they know
            self.clock = Some((now, Instant::now()));
            batch.push(Message::Binary(framed(&[&[TIME], &nanoseconds(now)])));
        }
        batch.extend(messages);
        if !batch.is_empty() {
            if self.batch == self.acknowledged {
                self.heard = Instant::now();
            }
            self.batch += 1;
            let number = Bytes::copy_from_slice(&self.batch.to_le_bytes());
            batch.push(Message::Ping(number));
        }
        batch
    }

    /// New channels, and the end of the run.
    fn news(&mut self, feed: &Feed) -> Vec<Message> {
        let mut news = Vec::new();
        let is_recent = |last: Instant| last.elapsed() < DISCOVERY;
        if !self.discovered.is_some_and(is_recent) {
            self.discovered = Some(Instant::now());
            let (found, outdated) = self.channels.discover(feed);
            self.subscriptions
                .retain(|_, it| !outdated.contains(&it.channel));
            news.extend(found);
        }
        if feed.state().end.is_some() {
            news.extend(self.say_once(StatusLevel::Info, "the run has ended"));
        }
        news.into_iter()
            .map(|it| Message::text(it.to_string()))
            .collect()
    }

    /// The new messages of all subscriptions, by time.
    fn messages(&mut self, feed: &Feed) -> Vec<Message> {
        let mut skipped = 0;
        let mut messages = Vec::new();
        for (id, subscription) in &mut self.subscriptions {
            let Some(channel) = self.channels.get(subscription.channel) else {
                continue;
            };
            let new = new_messages(channel, subscription, (feed, self.is_held), &mut skipped);
            messages.extend(new.into_iter().map(|(at, data)| (at, *id, data)));
        }
        messages.sort_by_key(|(at, ..)| *at);
        let mut batch = Vec::new();
        if skipped > 0 {
            self.skipped.fetch_add(skipped, Ordering::Relaxed);
            let reason = if self.is_held {
                "messages were skipped, because this viewer or its network is too slow: it receives the newest ones"
            } else {
                "samples were skipped, because an output writes more of them than viewers receive: the newest ones are sent"
            };
            let said = self.say_once(StatusLevel::Warning, reason);
            batch.extend(said.map(|it| Message::text(it.to_string())));
        }
        self.is_held = false;
        batch.extend(messages.into_iter().map(|(at, id, data)| {
            let head = [&[MESSAGE_DATA], &id.to_le_bytes()[..], &nanoseconds(at)];
            Message::Binary(framed(&[head[0], head[1], head[2], &data]))
        }));
        batch
    }

    /// A message to the user, unless it was sent before: viewers collect them.
    fn say_once(&mut self, level: StatusLevel, text: &'static str) -> Option<Value> {
        if self.said.contains(&text) {
            return None;
        }
        self.said.push(text);
        Some(status(level, text))
    }
}

fn status(level: StatusLevel, text: &str) -> Value {
    json!({ "op": "status", "level": level as u8, "message": text, "id": text })
}

fn framed(parts: &[&[u8]]) -> Bytes {
    parts.concat().into()
}

fn nanoseconds(at: Time) -> [u8; 8] {
    u64::try_from(at.nanos()).unwrap_or_default().to_le_bytes()
}

/// The cursors of a new subscription: the newest sample, the last step, and recent entries of the log are new to it.
fn beginning(source: &ChannelSource, feed: &Feed) -> BTreeMap<Arc<str>, u64> {
    let state = feed.state();
    match source {
        ChannelSource::Samples(_) | ChannelSource::Frames(_) | ChannelSource::State(..) => {
            BTreeMap::new()
        }
        ChannelSource::Steps(component) => {
            let last = state
                .history
                .get(component)
                .map_or(0, |it| it.cursor_before(1));
            BTreeMap::from([("".into(), last)])
        }
        ChannelSource::Log => BTreeMap::from([
            ("log".into(), state.log.cursor_before(RECENT)),
            ("calls".into(), state.calls.cursor_before(RECENT)),
        ]),
    }
}

/// The messages of a channel that are new, and the number of those that were skipped.
fn new_messages(
    channel: &ViewerChannel,
    subscription: &mut ViewerSubscription,
    (feed, was_held): (&Feed, bool),
    skipped: &mut u64,
) -> Vec<ChannelMessage> {
    match &channel.source {
        ChannelSource::Samples(slots) => {
            let new = slots
                .iter()
                .flat_map(|slot| new_samples(slot, subscription, was_held, skipped));
            new.filter_map(|it| Some((it.at, it.encoded(&channel.schema)?.to_vec())))
                .collect()
        }
        ChannelSource::Frames(slot) => {
            let new = new_samples(slot, subscription, was_held, &mut 0).into_iter();
            new.filter_map(|it| Some((it.at, messages::frame(&it.datum()?)?)))
                .collect()
        }
        ChannelSource::Steps(component) => {
            let entries = {
                let state = feed.state();
                let Some(ring) = state.history.get(component) else {
                    return Vec::new();
                };
                let cursor = subscription.sent.entry("".into()).or_default();
                unread(ring, cursor, skipped)
            };
            entries.iter().filter_map(|it| messages::step(it)).collect()
        }
        ChannelSource::State(component, control_state) => {
            let state = feed.state();
            let Some(known) = state.specifications.get(component) else {
                return Vec::new();
            };
            // the system waits meanwhile
            let is_large = known.values().len() > LARGE;
            let was_sent = subscription.state_sent.map(|it| it.elapsed());
            if is_large && was_sent.is_some_and(|it| it < LARGE_INTERVAL) {
                return Vec::new();
            }
            // the initial state is new as well
            let (cursor, version) = (
                subscription.sent.entry("".into()).or_default(),
                known.reported() + 1,
            );
            if std::mem::replace(cursor, version) == version {
                return Vec::new();
            }
            subscription.state_sent = Some(Instant::now());
            vec![messages::state(known, control_state.as_deref())]
        }
        ChannelSource::Log => log_entries(&mut subscription.sent, feed, skipped),
    }
}

fn log_entries(
    sent: &mut BTreeMap<Arc<str>, u64>,
    feed: &Feed,
    skipped: &mut u64,
) -> Vec<ChannelMessage> {
    let (log, calls) = {
        let state = feed.state();
        let log = unread(&state.log, sent.entry("log".into()).or_default(), skipped);
        let calls = unread(
            &state.calls,
            sent.entry("calls".into()).or_default(),
            skipped,
        );
        (log, calls)
    };
    let log = log.iter().filter_map(|it| messages::log(it, false));
    let calls = calls.iter().filter_map(|it| messages::log(it, true));
    log.chain(calls).collect()
}

/// The entries of a ring since a cursor, for use after its lock was released: the system writes under the same lock.
fn unread(ring: &Ring<Arc<str>>, cursor: &mut u64, skipped: &mut u64) -> Vec<Arc<str>> {
    let reading = ring.since(*cursor);
    *cursor = reading.next;
    *skipped += reading.missed;
    reading.entries.cloned().collect()
}

/// The new samples of an output, and the number of those that are not sent; after a pause only the newest one.
fn new_samples(
    slot: &Arc<OutputSlot>,
    subscription: &mut ViewerSubscription,
    was_held: bool,
    skipped: &mut u64,
) -> Vec<Arc<NewestSample>> {
    let last = subscription.sent.get(&slot.name).copied();
    if last.is_none() {
        subscription.followed.push(SlotFollower::new(slot));
    }
    let mut new = slot.all_newer_than(last.unwrap_or_default());
    if was_held || last.is_none() {
        new.drain(..new.len().saturating_sub(1));
    }
    let Some(newest) = new.last() else {
        return new;
    };
    if let Some(last) = last {
        *skipped += newest.number - last - new.len() as u64;
    }
    subscription
        .sent
        .insert(Arc::clone(&slot.name), newest.number);
    new
}
