//! What a viewer has subscribed to, what of it it has received, and the next batch of messages for it.

use std::collections::BTreeSet;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::{Duration, Instant};

use asmotion_component::Time;
use serde::Deserialize;
use serde_json::{Value, json};
use tungstenite::{Bytes, Message};

use super::channels::ChannelSource;
use super::shared_messages::{ChannelReader, SharedMessages, Subscribed, nanoseconds};
use crate::client::Client;
use crate::feed::Feed;
use crate::output_slot::{KeptSamples, SlotFollower};
use crate::subscriptions::RECENT;
use crate::ticker::TICK;
use crate::under_way::UnderWay;

/// Time without a pong after which the viewer is taken to be gone.
const GONE: Duration = Duration::from_secs(60);
/// Interval at which the time is sent although nothing else is new.
const CLOCK: Duration = Duration::from_millis(100);

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

/// The level of a message to the user.
#[derive(Clone, Copy)]
enum StatusLevel {
    Info = 0,
    Warning = 1,
    Error = 2,
}

/// The state of a session with a viewer.
pub(super) struct Viewer {
    /// The first message.
    info: String,
    feed: Feed,
    max_channels: usize,
    /// The channels that it knows.
    advertised: BTreeSet<u32>,
    /// The version of the channels that it knows; `None` before the first one.
    version: Option<u64>,
    /// What it has subscribed to, and what of it it has received.
    subscriptions: Arc<Subscribed>,
    /// The outputs among the sources, which keep their recent samples.
    followed: Vec<SlotFollower>,
    /// Number of the last batch.
    batch: u64,
    /// The batches that ended with a ping.
    under_way: UnderWay,
    /// Time of the last pong, or of the first ping without one.
    heard: Instant,
    /// The time that was sent last, and when.
    clock: Option<(Time, Instant)>,
    /// Whether a batch was due that had to wait for a pong.
    is_held: bool,
    /// What was said, which is not repeated.
    said: Vec<&'static str>,
    /// Number of messages that were skipped, for all viewers.
    skipped: Arc<AtomicU64>,
}

impl Client for Viewer {
    type Shared = SharedMessages;

    fn greeting(&mut self) -> Message {
        Message::text(std::mem::take(&mut self.info))
    }

    fn receive(&mut self, text: &str, shared: &mut SharedMessages) -> Vec<Message> {
        let problems = self.request(text, shared).into_iter();
        problems.map(|it| Message::text(it.to_string())).collect()
    }

    fn pong(&mut self, content: &[u8]) {
        let Ok(batch) = content.try_into().map(u64::from_le_bytes) else {
            return;
        };
        if batch <= self.batch && self.under_way.acknowledge(batch) {
            self.heard = Instant::now();
        }
    }

    fn interval(&self) -> Duration {
        TICK
    }

    fn news(&mut self, shared: &mut SharedMessages, _is_last: bool) -> Option<Vec<Message>> {
        if self.under_way.is_awaited() && self.heard.elapsed() > GONE {
            return None;
        }
        Some(self.batch(shared))
    }
}

impl Viewer {
    pub(super) fn new(
        info: String,
        feed: Feed,
        max_channels: usize,
        skipped: Arc<AtomicU64>,
    ) -> Self {
        Self {
            info,
            feed,
            max_channels,
            advertised: BTreeSet::new(),
            version: None,
            subscriptions: Arc::default(),
            followed: Vec::new(),
            batch: 0,
            under_way: UnderWay::default(),
            heard: Instant::now(),
            clock: None,
            is_held: false,
            said: Vec::new(),
            skipped,
        }
    }

    /// Handles a message of the viewer. Returns what the user should know.
    fn request(&mut self, text: &str, shared: &SharedMessages) -> Vec<Value> {
        match serde_json::from_str(text) {
            Ok(ViewerRequest::Subscribe { subscriptions }) => subscriptions
                .into_iter()
                .filter_map(|wanted| self.subscribe(&wanted, shared).err())
                .map(|problem| status(StatusLevel::Warning, &problem))
                .collect(),
            Ok(ViewerRequest::Unsubscribe { subscription_ids }) => {
                let subscriptions = Arc::make_mut(&mut self.subscriptions);
                for id in subscription_ids {
                    subscriptions.remove(&id);
                }
                self.follow(shared);
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

    fn subscribe(
        &mut self,
        wanted: &WantedSubscription,
        shared: &SharedMessages,
    ) -> Result<(), String> {
        let WantedSubscription { id, channel_id } = wanted;
        let channel = shared.channels().get(*channel_id);
        let Some(channel) = channel.filter(|_| self.advertised.contains(channel_id)) else {
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
        let reader = ChannelReader::new(*channel_id, &channel.source, &self.feed, RECENT);
        Arc::make_mut(&mut self.subscriptions).insert(*id, reader);
        self.follow(shared);
        Ok(())
    }

    /// Lets the outputs that are subscribed to keep their recent samples.
    fn follow(&mut self, shared: &SharedMessages) {
        let channels = self.subscriptions.values();
        let channels = channels.filter_map(|it| shared.channels().get(it.channel));
        let slots = channels.flat_map(|channel| match &channel.source {
            ChannelSource::Samples(slots) => &slots[..],
            ChannelSource::Frames(slot) => std::slice::from_ref(slot),
            ChannelSource::Steps(_) | ChannelSource::State(..) | ChannelSource::Log => &[],
        });
        // the new ones before the old ones end
        self.followed = slots
            .map(|slot| SlotFollower::new(slot, KeptSamples::Recent))
            .collect();
    }

    /// The next messages; empty if nothing is new, or if the viewer has to answer a ping first.
    fn batch(&mut self, shared: &mut SharedMessages) -> Vec<Message> {
        if !self.under_way.has_room() {
            self.is_held = true;
            return Vec::new();
        }
        let mut batch = self.news(shared);
        let messages = self.messages(shared);
        let now = self.feed.state().time;
        let is_due = self.clock.is_none_or(|(sent, when)| {
            sent != now && (!messages.is_empty() || when.elapsed() >= CLOCK)
        });
        if is_due {
            // before the messages: viewers give them the time that they know
            self.clock = Some((now, Instant::now()));
            let time = [&[TIME], &nanoseconds(now)[..]].concat();
            batch.push(Message::Binary(time.into()));
        }
        batch.extend(messages);
        if !batch.is_empty() {
            let now = Instant::now();
            if !self.under_way.is_awaited() {
                self.heard = now;
            }
            self.batch += 1;
            if self.under_way.ask(self.batch, now) {
                let number = Bytes::copy_from_slice(&self.batch.to_le_bytes());
                batch.push(Message::Ping(number));
            }
        }
        batch
    }

    /// New channels, and the end of the run.
    fn news(&mut self, shared: &mut SharedMessages) -> Vec<Message> {
        let mut news = Vec::new();
        let channels = shared.discover(&self.feed);
        if self.version != Some(channels.version()) {
            self.version = Some(channels.version());
            news.extend(channels.tell(&mut self.advertised));
            let advertised = &self.advertised;
            Arc::make_mut(&mut self.subscriptions).retain(|_, it| advertised.contains(&it.channel));
            self.follow(shared);
        }
        if self.feed.state().end.is_some() {
            news.extend(self.say_once(StatusLevel::Info, "the run has ended"));
        }
        news.into_iter()
            .map(|it| Message::text(it.to_string()))
            .collect()
    }

    /// The new messages of all subscriptions, by time.
    fn messages(&mut self, shared: &mut SharedMessages) -> Vec<Message> {
        let source = (&self.feed, self.is_held);
        let new = shared.news(&mut self.subscriptions, source);
        let mut batch = Vec::new();
        if new.skipped > 0 {
            self.skipped.fetch_add(new.skipped, Ordering::Relaxed);
            let reason = if self.is_held {
                "messages were skipped, because this viewer or its network is too slow: it receives the newest ones"
            } else {
                "samples were skipped, because an output writes more of them than viewers receive: the newest ones are sent"
            };
            let said = self.say_once(StatusLevel::Warning, reason);
            batch.extend(said.map(|it| Message::text(it.to_string())));
        }
        self.is_held = false;
        batch.extend(new.messages);
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
