//! The channels that a viewer can subscribe to.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

use asmotion_viewer_encoding::ChannelSchema;
use serde_json::{Value, json};

use super::messages;
use crate::feed::Feed;
use crate::output_slot::OutputSlot;

/// Type of the messages that also give the place of a frame.
const ODOMETRY: &str = "nav_msgs/msg/Odometry";

/// A channel. Channels of topics, outputs and steps have the names that they have in a recording.
pub(super) struct ViewerChannel {
    pub name: String,
    pub schema: Arc<ChannelSchema>,
    pub source: ChannelSource,
}

/// The origin of the messages of a channel.
pub(super) enum ChannelSource {
    /// Samples of outputs: of the one output, or of all outputs that write to the topic.
    Samples(Vec<Arc<OutputSlot>>),
    /// The frame that the samples of an output place.
    Frames(Arc<OutputSlot>),
    /// Steps of the specification of this component that wrote something.
    Steps(String),
    /// State of the specification of this component, and its control state.
    State(String, Option<String>),
    /// The log.
    Log,
}

impl ChannelSource {
    /// Returns whether this is the same origin.
    fn is(&self, other: &Self) -> bool {
        match (self, other) {
            (Self::Samples(these), Self::Samples(those)) => {
                let pairs = these.iter().zip(those);
                these.len() == those.len()
                    && pairs.into_iter().all(|(one, it)| Arc::ptr_eq(one, it))
            }
            (Self::Frames(one), Self::Frames(it)) => Arc::ptr_eq(one, it),
            (Self::Steps(one), Self::Steps(it)) => one == it,
            (Self::State(component, state), Self::State(it, known)) => {
                component == it && state == known
            }
            (Self::Log, Self::Log) => true,
            (
                Self::Samples(_) | Self::Frames(_) | Self::Steps(_) | Self::State(..) | Self::Log,
                _,
            ) => false,
        }
    }
}

/// The channels by number, for all viewers. Numbers are not used again.
#[derive(Default)]
pub(super) struct ViewerChannels {
    known: BTreeMap<u32, ViewerChannel>,
    last: u32,
    /// Number of times that channels came, went, or got other sources.
    version: u64,
}

impl ViewerChannels {
    pub(super) fn get(&self, id: u32) -> Option<&ViewerChannel> {
        self.known.get(&id)
    }

    /// Number of times that channels came, went, or got other sources.
    pub(super) fn version(&self) -> u64 {
        self.version
    }

    /// Finds what is new.
    pub(super) fn discover(&mut self, feed: &Feed) {
        let found = found(feed);
        let before = self.known.len();
        self.known.retain(|_, channel| {
            let same = found.get(&channel.name);
            same.is_some_and(|it| it.schema == channel.schema)
        });
        let mut is_other = self.known.len() < before;
        for (name, channel) in found {
            let known = self.known.values_mut().find(|it| it.name == name);
            if let Some(known) = known {
                if !known.source.is(&channel.source) {
                    *known = channel;
                    is_other = true;
                }
                continue;
            }
            self.last += 1;
            self.known.insert(self.last, channel);
            is_other = true;
        }
        self.version += u64::from(is_other);
    }

    /// Makes the channels that a viewer knows equal to these. Returns the messages that say so to the viewer.
    pub(super) fn tell(&self, advertised: &mut BTreeSet<u32>) -> Vec<Value> {
        let outdated = advertised.iter().filter(|id| !self.known.contains_key(id));
        let outdated: Vec<u32> = outdated.copied().collect();
        let new = self.known.iter().filter(|(id, _)| !advertised.contains(id));
        let new: Vec<Value> = new.map(|(id, channel)| described(*id, channel)).collect();
        *advertised = self.known.keys().copied().collect();
        let mut news = Vec::new();
        if !outdated.is_empty() {
            news.push(json!({ "op": "unadvertise", "channelIds": outdated }));
        }
        if !new.is_empty() {
            news.push(json!({ "op": "advertise", "channels": new }));
        }
        news
    }
}

fn described(id: u32, channel: &ViewerChannel) -> Value {
    let schema = &channel.schema;
    json!({
        "id": id, "topic": channel.name, "encoding": schema.message_encoding(),
        "schemaName": schema.name(), "schema": schema.definition(), "schemaEncoding": schema.definition_encoding(),
    })
}

/// All channels of a system, by name.
fn found(feed: &Feed) -> BTreeMap<String, ViewerChannel> {
    let mut found = BTreeMap::new();
    let mut add = |name: String, schema, source| {
        let channel = ViewerChannel {
            name: name.clone(),
            schema,
            source,
        };
        found.entry(name).or_insert(channel);
    };
    add("log".to_owned(), messages::log_schema(), ChannelSource::Log);
    let control_states: BTreeMap<_, _> = feed.system().control_states().into_iter().collect();
    let specifications: Vec<String> = feed.state().specifications.keys().cloned().collect();
    for component in specifications {
        let steps = ChannelSource::Steps(component.clone());
        add(
            format!("asm/{component}/step"),
            messages::step_schema(),
            steps,
        );
        let control_state = control_states.get(&component).cloned();
        let name = format!("asm/{component}/state");
        let state = ChannelSource::State(component, control_state);
        add(name, messages::state_schema(), state);
    }
    let mut by_topic: BTreeMap<String, (Arc<ChannelSchema>, Vec<Arc<OutputSlot>>)> =
        BTreeMap::new();
    for slot in feed.slots() {
        let Some(schema) = feed.schema_of(&slot) else {
            continue;
        };
        if schema.name() == ODOMETRY {
            let name = format!("frame/{}", slot.name);
            let frames = ChannelSource::Frames(Arc::clone(&slot));
            add(name, messages::frame_schema(), frames);
        }
        let name = match slot.topic() {
            Some(topic) => format!("topic/{topic}"),
            None => format!("port/{}", slot.name),
        };
        let (of_channel, slots) = by_topic
            .entry(name)
            .or_insert_with(|| (Arc::clone(&schema), Vec::new()));
        // all outputs of a topic have its type; a message of another one could not be decoded
        if **of_channel == *schema {
            slots.push(slot);
        }
    }
    for (name, (schema, slots)) in by_topic {
        add(name, schema, ChannelSource::Samples(slots));
    }
    found
}
