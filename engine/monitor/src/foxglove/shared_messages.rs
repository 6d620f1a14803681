//! What viewers share: the channels, and the batches of a tick, each of which is encoded once.

use std::collections::BTreeMap;
use std::sync::Arc;
use std::time::{Duration, Instant};

use asmotion_component::Time;
use tungstenite::{Bytes, Message};

use super::channels::{ChannelSource, ViewerChannel, ViewerChannels};
use super::messages;
use crate::feed::Feed;
use crate::output_slot::{NewestSample, OutputSlot};
use crate::ring::Ring;
use crate::ticker::Shared;

/// Interval at which new channels are searched for.
const DISCOVERY: Duration = Duration::from_millis(250);

/// Number of locations above which states are sent less often.
const LARGE: usize = 1000;
/// Interval between such states.
const LARGE_INTERVAL: Duration = Duration::from_secs(1);

/// Opcode of the binary message that has a message of a channel.
const MESSAGE_DATA: u8 = 1;

/// What viewers share.
#[derive(Default)]
pub(crate) struct SharedMessages {
    channels: ViewerChannels,
    discovered: Option<Instant>,
    /// What is new in this tick.
    news: Vec<SharedNews>,
}

/// What is new for viewers that have subscribed to the same by the same numbers, and have received the same.
struct SharedNews {
    before: Arc<Subscribed>,
    was_held: bool,
    new: NewMessages,
    /// What they have received with it.
    after: Arc<Subscribed>,
}

/// The subscriptions of a viewer, by the number that it has given them.
pub(super) type Subscribed = BTreeMap<u32, ChannelReader>;

/// What a viewer has received of a channel.
#[derive(Clone, PartialEq, Eq)]
pub(super) struct ChannelReader {
    pub channel: u32,
    /// Numbers of the last message of each source.
    sent: BTreeMap<Arc<str>, u64>,
    /// Time of the last state that was sent, if it is large.
    state_sent: Option<Instant>,
}

/// New messages, by the times of the run at which they came into being.
#[derive(Clone, Default)]
pub(super) struct NewMessages {
    pub messages: Vec<Message>,
    /// Number of messages that are not sent.
    pub skipped: u64,
}

/// The content of a message, with its time.
type Content = (Time, Vec<u8>);

impl Shared for SharedMessages {
    fn begin(&mut self, _now: Instant) {
        self.news.clear();
    }
}

impl SharedMessages {
    /// The channels.
    pub(super) fn channels(&self) -> &ViewerChannels {
        &self.channels
    }

    /// Searches for new channels, if it is time.
    pub(super) fn discover(&mut self, feed: &Feed) -> &ViewerChannels {
        let is_recent = |last: Instant| last.elapsed() < DISCOVERY;
        if !self.discovered.is_some_and(is_recent) {
            self.discovered = Some(Instant::now());
            self.channels.discover(feed);
        }
        &self.channels
    }

    /// What is new for a viewer. After a pause (`was_held`) only the newest samples are.
    pub(super) fn news(
        &mut self,
        subscribed: &mut Arc<Subscribed>,
        (feed, was_held): (&Feed, bool),
    ) -> NewMessages {
        // viewers that keep up have the same pointer from their second batch on
        let mut known = self.news.iter();
        let known = known.find(|it| it.was_held == was_held && it.before == *subscribed);
        if let Some(known) = known {
            *subscribed = Arc::clone(&known.after);
            return known.new.clone();
        }
        let before = Arc::clone(subscribed);
        let mut messages = Vec::new();
        let mut skipped = 0;
        for (id, reader) in Arc::make_mut(subscribed) {
            let Some(channel) = self.channels.get(reader.channel) else {
                continue;
            };
            let contents = reader.read(channel, (feed, was_held), &mut skipped);
            messages.extend(contents.into_iter().map(|content| (*id, content)));
        }
        messages.sort_by_key(|(_, (at, _))| *at);
        let framed = messages.into_iter().map(|(id, (at, data))| {
            let (id, at) = (id.to_le_bytes(), nanoseconds(at));
            let parts: [&[u8]; 4] = [&[MESSAGE_DATA], &id, &at, &data];
            Message::Binary(Bytes::from(parts.concat()))
        });
        let new = NewMessages {
            messages: framed.collect(),
            skipped,
        };
        self.news.push(SharedNews {
            before,
            was_held,
            new: new.clone(),
            after: Arc::clone(subscribed),
        });
        new
    }
}

/// A time as it is in messages.
pub(super) fn nanoseconds(at: Time) -> [u8; 8] {
    u64::try_from(at.nanos()).unwrap_or_default().to_le_bytes()
}

impl ChannelReader {
    /// A reader of a new subscription: the newest sample, the last step, and recent entries of the log are new to it.
    pub(super) fn new(channel: u32, source: &ChannelSource, feed: &Feed, recent: usize) -> Self {
        let state = feed.state();
        let sent = match source {
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
                ("log".into(), state.log.cursor_before(recent)),
                ("calls".into(), state.calls.cursor_before(recent)),
            ]),
        };
        Self {
            channel,
            sent,
            state_sent: None,
        }
    }

    /// The messages that are new, and the number of those that are skipped.
    fn read(
        &mut self,
        channel: &ViewerChannel,
        (feed, was_held): (&Feed, bool),
        skipped: &mut u64,
    ) -> Vec<Content> {
        match &channel.source {
            ChannelSource::Samples(slots) => {
                let new = slots
                    .iter()
                    .flat_map(|slot| self.samples(slot, was_held, skipped));
                new.filter_map(|it| Some((it.at, it.encoded(&channel.schema)?.to_vec())))
                    .collect()
            }
            ChannelSource::Frames(slot) => {
                let new = self.samples(slot, was_held, &mut 0).into_iter();
                new.filter_map(|it| Some((it.at, messages::frame(&*it.datum().ok()?)?)))
                    .collect()
            }
            ChannelSource::Steps(component) => {
                let entries = {
                    let state = feed.state();
                    let Some(ring) = state.history.get(component) else {
                        return Vec::new();
                    };
                    let cursor = self.sent.entry("".into()).or_default();
                    unread(ring, cursor, skipped)
                };
                entries.iter().filter_map(|it| messages::step(it)).collect()
            }
            ChannelSource::State(component, control_state) => {
                let state = self.state(component, control_state.as_deref(), feed);
                state.into_iter().collect()
            }
            ChannelSource::Log => self.log(feed, skipped),
        }
    }

    fn state(
        &mut self,
        component: &str,
        control_state: Option<&str>,
        feed: &Feed,
    ) -> Option<Content> {
        let state = feed.state();
        let known = state.specifications.get(component)?;
        // the system waits meanwhile
        let is_large = known.values().len() > LARGE;
        let was_sent = self.state_sent.map(|it| it.elapsed());
        if is_large && was_sent.is_some_and(|it| it < LARGE_INTERVAL) {
            return None;
        }
        // the initial state is new as well
        let version = known.reported() + 1;
        if self.sent.insert("".into(), version) == Some(version) {
            return None;
        }
        self.state_sent = is_large.then(Instant::now);
        Some(messages::state(known, control_state))
    }

    fn log(&mut self, feed: &Feed, skipped: &mut u64) -> Vec<Content> {
        let sent = &mut self.sent;
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
        let log = log.iter().filter_map(|it| messages::log(&it.json, false));
        let calls = calls.iter().filter_map(|it| messages::log(&it.json, true));
        log.chain(calls).collect()
    }

    /// The new samples of an output, and the number of those that are not sent; after a pause only the newest one.
    fn samples(
        &mut self,
        slot: &Arc<OutputSlot>,
        was_held: bool,
        skipped: &mut u64,
    ) -> Vec<Arc<NewestSample>> {
        let last = self.sent.get(&slot.name).copied();
        let mut new = slot.recent_newer_than(last.unwrap_or_default());
        if was_held || last.is_none() {
            new.drain(..new.len().saturating_sub(1));
        }
        let Some(newest) = new.last() else {
            return new;
        };
        if let Some(last) = last {
            *skipped += newest.number - last - new.len() as u64;
        }
        self.sent.insert(Arc::clone(&slot.name), newest.number);
        new
    }
}

/// The entries of a ring since a cursor, for use after its lock was released: the system writes under the same lock.
fn unread<T: Clone>(ring: &Ring<T>, cursor: &mut u64, skipped: &mut u64) -> Vec<T> {
    let reading = ring.since(*cursor);
    *cursor = reading.next;
    *skipped += reading.missed;
    reading.entries.cloned().collect()
}
