//! The seam: what a bus does, whichever carries it.

use std::sync::Arc;
use std::time::Duration;

use asmotion_datum::Schema;

use crate::{
    Health, Notifier, Pattern, Payload, PendingCall, PublishOptions, PublisherCounts, QueuePolicy,
    Request, ServedAddress, Subscription, TraceContext,
};

/// A bus: topics and addresses shared by processes.
///
/// Between one publisher and one subscription messages keep their order; a subscription sees what was published after
/// it began. Publishing never waits for a subscriber.
pub trait Bus: Send + Sync {
    /// A publisher of one topic, of messages of this shape. Types are compared where messages are read; a topic should
    /// have one.
    fn publisher(
        &self,
        topic: &str,
        origin: &SenderId,
        schema: &Schema,
        sending: PublishOptions,
    ) -> Result<Box<dyn Publisher>, BusError>;

    /// All messages of the topics that match a pattern, from now on, for one reader, whose name operators see. The notifier
    /// is notified of each.
    fn subscribe(
        &self,
        reader: &str,
        pattern: &Pattern,
        queue: QueuePolicy,
        notifier: Arc<Notifier>,
    ) -> Result<Subscription, BusError>;

    /// Serves requests at an address; one server at a time. At most `size` requests wait.
    fn serve(
        &self,
        address: &str,
        size: usize,
        notifier: Arc<Notifier>,
    ) -> Result<ServedAddress, BusError>;

    /// Sends a request to an address. It ends with an answer, or with a [`CallFailure`](crate::CallFailure): at once
    /// if nobody serves there, else at the deadline.
    fn call(
        &self,
        address: &str,
        request: Request,
        notifier: Arc<Notifier>,
    ) -> Result<PendingCall, BusError>;

    /// Sends a request that has no answer (SCA `@OneWay`). It ends with nothing when the server's queue has it, else
    /// with a failure; who does not care drops it.
    fn tell(
        &self,
        address: &str,
        request: Request,
        notifier: Arc<Notifier>,
    ) -> Result<PendingCall, BusError>;

    /// Sends the last message of each publisher that [keeps it](PublishOptions::init) again, as the same message: those who
    /// came late get it, those who have it take it out.
    fn repeat(&self);

    /// The state of the transport.
    fn health(&self) -> Health;

    /// Notifies at every change of the [`health`](Self::health), as long as somebody else holds it too.
    fn watch(&self, notifier: &Arc<Notifier>);

    /// Waits until all that was published has left, and was confirmed where that was asked for; or so long. Says
    /// whether it has.
    fn drain(&self, at_most: Duration) -> bool;
}

/// Who publishes or calls.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct SenderId {
    /// The component.
    pub source: Arc<str>,
    /// Which life of its process: grows with every restart.
    pub incarnation: u64,
}

impl SenderId {
    /// A component in a life of its process.
    pub fn new(source: impl Into<Arc<str>>, incarnation: u64) -> Self {
        Self {
            source: source.into(),
            incarnation,
        }
    }
}

/// Publishes on one topic; numbers its messages from 1.
pub trait Publisher: Send {
    /// Publishes a message, sent at `stamp` nanoseconds of the sender's clock. Never waits.
    fn publish(&mut self, stamp: i64, payload: Payload) -> Result<(), BusError> {
        self.publish_within(stamp, payload, None)
    }

    /// Publishes a message in the trace of what it follows from. Without that, it is the first of a trace.
    fn publish_within(
        &mut self,
        stamp: i64,
        payload: Payload,
        cause: Option<TraceContext>,
    ) -> Result<(), BusError>;

    /// What has become of the messages so far.
    fn sent(&self) -> PublisherCounts;
}

/// Why a bus cannot do what is asked.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum BusError {
    /// Somebody else serves there.
    #[error("`{address}` is served already")]
    Served {
        /// The address.
        address: String,
    },
    /// The transport is not there, and the topic's outage policy keeps nothing more; it is counted.
    #[error("no connection: {reason}")]
    Disconnected {
        /// Why.
        reason: String,
    },
    /// The transport does not let us.
    #[error("refused: {reason}")]
    Refused {
        /// Why.
        reason: String,
    },
    /// A name that the transport cannot carry.
    #[error("`{name}` cannot name a topic or an address: {reason}")]
    BadName {
        /// The name.
        name: String,
        /// Why.
        reason: String,
    },
}
