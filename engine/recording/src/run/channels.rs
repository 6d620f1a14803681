//! The channels of a recording, by what they record.

use std::collections::BTreeMap;
use std::sync::Arc;

use asmotion_viewer_encoding::RosType;

use super::queue::ChannelAbout;

/// Kind of the messages in a channel.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum ChannelKind {
    /// Messages of a topic.
    Topic,
    /// Samples of a port.
    Port,
    /// Calls of an operation, by the caller.
    Call,
    /// Replies of an operation, by the provider.
    Answer,
    /// Steps of a coordinator.
    Step,
    /// Events.
    Event,
    /// Marks at which a reader may want to begin.
    Mark,
}

/// The place of a message: the number of its channel, its number there, and its type.
#[derive(Clone, Debug)]
pub(super) struct MessagePlace {
    pub channel: u32,
    pub sequence: u32,
    /// Type of ROS 2; `None` for JSON.
    pub ros: Option<Arc<RosType>>,
}

#[derive(Debug)]
struct RecordedChannel {
    /// `None` if the patterns leave it out.
    number: Option<u32>,
    /// Number of its last message.
    sequence: u32,
    /// Type of ROS 2 of its messages; `None` for JSON.
    ros: Option<Arc<RosType>>,
}

type ChannelsByName = BTreeMap<String, RecordedChannel>;

/// Channels by kind, owner and name; known ones are found without an allocation.
#[derive(Debug, Default)]
pub(super) struct ChannelTable {
    known: BTreeMap<ChannelKind, BTreeMap<String, ChannelsByName>>,
    /// Number of channels so far.
    count: u32,
}

impl ChannelTable {
    /// Returns the place of the next message of a channel; `None` if the channel is unknown or left out.
    pub fn next(&mut self, kind: ChannelKind, owner: &str, name: &str) -> Option<MessagePlace> {
        let channel = self.known.get_mut(&kind)?.get_mut(owner)?.get_mut(name)?;
        let number = channel.number?;
        channel.sequence = channel.sequence.wrapping_add(1);
        Some(MessagePlace {
            channel: number,
            sequence: channel.sequence,
            ros: channel.ros.clone(),
        })
    }

    /// Returns whether the channel was added.
    pub fn is_known(&self, kind: ChannelKind, owner: &str, name: &str) -> bool {
        let of_owner = self.known.get(&kind).and_then(|owners| owners.get(owner));
        of_owner.is_some_and(|names| names.contains_key(name))
    }

    /// Adds a channel, or that it is left out. Returns its number.
    pub fn add(
        &mut self,
        kind: ChannelKind,
        owner: &str,
        name: &str,
        about: Option<&ChannelAbout>,
    ) -> Option<u32> {
        let number = about.map(|_| {
            self.count += 1;
            self.count
        });
        let owners = self.known.entry(kind).or_default();
        let names = owners.entry(owner.to_owned()).or_default();
        let channel = RecordedChannel {
            number,
            sequence: 0,
            ros: about.and_then(|about| about.schema.ros_type().cloned()),
        };
        names.insert(name.to_owned(), channel);
        number
    }
}
