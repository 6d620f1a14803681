//! The channels that a viewer can subscribe to.

use std::collections::BTreeMap;
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
#[derive(Clone)]
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

/// The channels by number. Numbers are not used again.
#[derive(Default)]
pub(super) struct ViewerChannels {
    known: BTreeMap<u32, ViewerChannel>,
    last: u32,
}

impl ViewerChannels {
    pub(super) fn get(&self, id: u32) -> Option<&ViewerChannel> {
        self.known.get(&id)
    }

    /// Finds what is new. Returns the messages that say so, and the numbers of the channels that no longer exist.
    pub(super) fn discover(&mut self, feed: &Feed) -> (Vec<Value>, Vec<u32>) {
        let found = found(feed);
        let is_current = |channel: &ViewerChannel| {
            let same = found.get(&channel.name);
            same.is_some_and(|it| it.schema == channel.schema)
        };
        let outdated = self.known.iter().filter(|(_, it)| !is_current(it));
        let outdated: Vec<u32> = outdated.map(|(id, _)| *id).collect();
        for id in &outdated {
            self.known.remove(id);
        }
        let mut advertised = Vec::new();
        for (name, channel) in found {
            let known = self.known.values_mut().find(|it| it.name == name);
            if let Some(known) = known {
                known.source = channel.source;
                continue;
            }
            self.last += 1;
            advertised.push(described(self.last, &channel));
            self.known.insert(self.last, channel);
        }
        let mut news = Vec::new();
        if !outdated.is_empty() {
            news.push(json!({ "op": "unadvertise", "channelIds": &outdated }));
        }
        if !advertised.is_empty() {
            news.push(json!({ "op": "advertise", "channels": advertised }));
        }
        (news, outdated)
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
