//! Options of a publisher: codec, delivery assurance, and what to keep while the transport is down.

use std::num::NonZeroUsize;
use std::time::Duration;

use asmotion_datum::Codec;

/// Options of a publisher.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct PublishOptions {
    /// Encoding, if the transport needs bytes.
    pub codec: Codec,
    /// Delivery assurance.
    pub assurance: Assurance,
    /// Messages to keep while the transport is down.
    pub outage: Outage,
    /// Keeps the last message for late subscribers; see [`Bus::republish_retained`](crate::Bus::republish_retained).
    pub init: bool,
    /// Age beyond which no reader uses a message: a message that has waited longer, here or in the transport, is dropped
    /// and counted. `None` keeps messages however old they are.
    pub max_age: Option<Duration>,
}

/// Delivery assurance of a topic.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Assurance {
    /// Sent once. A message in flight when the transport breaks is lost and counted. For states that are published
    /// again soon.
    #[default]
    Once,
    /// Kept until the transport has confirmed it, and sent again if the transport breaks before. For events and
    /// commands.
    Confirmed,
}

/// Policy for messages published while the transport is down or blocked. Dropped messages are counted.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Outage {
    /// Drops every message.
    #[default]
    Drop,
    /// Keeps the newest message.
    KeepLatest,
    /// Keeps this many of the oldest messages, in order, and rejects the rest.
    Queue(NonZeroUsize),
}

impl PublishOptions {
    /// Options for states that are published repeatedly: only the newest message is kept while the transport is down.
    pub fn state() -> Self {
        Self {
            outage: Outage::KeepLatest,
            ..Self::default()
        }
    }

    /// Options for events and commands: confirmed delivery, and up to `size` messages kept while the transport is
    /// down.
    pub fn events(size: NonZeroUsize) -> Self {
        Self {
            assurance: Assurance::Confirmed,
            outage: Outage::Queue(size),
            ..Self::default()
        }
    }

    /// Sets whether the last message is kept for late subscribers.
    #[must_use]
    pub fn init(mut self, init: bool) -> Self {
        self.init = init;
        self
    }

    /// Sets the age beyond which no reader uses a message.
    #[must_use]
    pub fn max_age(mut self, max_age: Option<Duration>) -> Self {
        self.max_age = max_age;
        self
    }

    /// Sets the encoding.
    #[must_use]
    pub fn with_codec(mut self, codec: Codec) -> Self {
        self.codec = codec;
        self
    }
}

/// Counts of a publisher's messages by outcome.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct PublisherCounts {
    /// Accepted from the publisher.
    pub published: u64,
    /// Known to have reached the transport.
    pub accepted: u64,
    /// Dropped by the outage policy, because of their age, or because they could not be encoded.
    pub dropped: u64,
    /// In flight when the transport broke; may or may not have arrived.
    pub lost: u64,
    /// Refused by the transport: a full queue, a missing permission.
    pub refused: u64,
    /// Delivered to the transport, but matched by no subscription.
    pub unrouted: u64,
}

impl PublisherCounts {
    /// Returns how many messages are still queued or in flight.
    pub fn pending(&self) -> u64 {
        let finished = self.accepted + self.dropped + self.lost + self.refused;
        self.published.saturating_sub(finished)
    }
}
