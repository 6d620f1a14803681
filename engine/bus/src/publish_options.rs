//! How a topic is sent: its codec, how sure its messages are to arrive, and what becomes of them without a broker.

use std::num::NonZeroUsize;

use asmotion_datum::Codec;

/// How the messages of a topic are sent.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct PublishOptions {
    /// How they are written where bytes are needed.
    pub codec: Codec,
    /// How sure they are to arrive.
    pub assurance: Assurance,
    /// What becomes of them while the transport is away.
    pub outage: Outage,
    /// Whether the last of them is kept for those who come late: see [`Bus::repeat`](crate::Bus::repeat).
    pub init: bool,
}

/// How sure messages are to arrive.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Assurance {
    /// Sent once. What is under way when the transport breaks is lost, and counted: for what comes again anyhow.
    #[default]
    Once,
    /// Kept until the transport has confirmed it, and sent again if it breaks before: for events and commands.
    Confirmed,
}

/// What becomes of messages published while the transport is away or takes nothing. What is dropped is counted.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Outage {
    /// They are dropped.
    #[default]
    Drop,
    /// The newest is kept.
    KeepLatest,
    /// The oldest so many are kept, in order; one more is refused.
    Queue(NonZeroUsize),
}

impl PublishOptions {
    /// For a state that is published again and again: the newest counts.
    pub fn state() -> Self {
        Self {
            outage: Outage::KeepLatest,
            ..Self::default()
        }
    }

    /// For events and commands: confirmed, and kept so many while the transport is away.
    pub fn events(size: NonZeroUsize) -> Self {
        Self {
            assurance: Assurance::Confirmed,
            outage: Outage::Queue(size),
            ..Self::default()
        }
    }

    /// The same, with the last message kept for those who come late, or not.
    #[must_use]
    pub fn init(mut self, init: bool) -> Self {
        self.init = init;
        self
    }

    /// The same, written by another codec.
    #[must_use]
    pub fn by(mut self, codec: Codec) -> Self {
        self.codec = codec;
        self
    }
}

/// What has become of a publisher's messages.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct PublisherCounts {
    /// Taken from the publisher.
    pub published: u64,
    /// Known to have reached the transport.
    pub arrived: u64,
    /// Dropped here, as the outage policy says, or because they could not be written.
    pub dropped: u64,
    /// Under way when the transport broke: perhaps arrived, perhaps not.
    pub lost: u64,
    /// Refused by the transport: a full queue, a missing permission.
    pub refused: u64,
    /// Arrived where nobody listens.
    pub unheard: u64,
}

impl PublisherCounts {
    /// How many are still kept or under way.
    pub fn open(&self) -> u64 {
        let done = self.arrived + self.dropped + self.lost + self.refused;
        self.published.saturating_sub(done)
    }
}
