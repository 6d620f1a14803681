//! The seam: what a bus does, whichever carries it.

use std::sync::Arc;
use std::time::Duration;

use asmotion_datum::Schema;

use crate::envelope::Payload;
use crate::health::Health;
use crate::pattern::Pattern;
use crate::publish_options::{PublishOptions, PublisherCounts};
use crate::queue::{QueuePolicy, Subscription};
use crate::request::{PendingCall, Request, ServedAddress};
use crate::trace_context::TraceContext;
use asmotion_connection::Notifier;

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

    /// Sends a request to an address. The call ends with an answer or with a [`CallFailure`](crate::CallFailure):
    /// immediately if no server is there, otherwise at the deadline.
    ///
    /// # Errors
    /// [`BusError::BadName`] if the transport cannot carry the address; failures of the call itself arrive in the
    /// [`PendingCall`].
    fn call(
        &self,
        address: &str,
        request: Request,
        notifier: Arc<Notifier>,
    ) -> Result<PendingCall, BusError>;

    /// Sends a request without an answer (SCA `@OneWay`). The call ends with nothing once the server's queue holds
    /// the request, otherwise with a failure; drop the [`PendingCall`] to ignore both.
    ///
    /// # Errors
    /// As [`call`](Self::call).
    fn tell(
        &self,
        address: &str,
        request: Request,
        notifier: Arc<Notifier>,
    ) -> Result<PendingCall, BusError>;

    /// Sends again the last message of each publisher that [retains it](PublishOptions::init), with its original
    /// number: late subscribers receive it, all others discard it as a duplicate.
    fn repeat(&self);

    /// The state of the transport.
    fn health(&self) -> Health;

    /// Notifies at every change of the [`health`](Self::health), as long as somebody else holds it too.
    fn watch(&self, notifier: &Arc<Notifier>);

    /// Waits until everything published has left, and has been confirmed where the publisher asked for that. Returns
    /// false if `at_most` passes first.
    fn drain(&self, at_most: Duration) -> bool;
}

/// Identity of a publisher or caller.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct SenderId {
    /// Name of the component.
    pub source: Arc<str>,
    /// Number of its process's current run; grows with every restart.
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

    /// Returns how many messages were published, delivered, dropped and lost so far.
    fn sent(&self) -> PublisherCounts;
}

/// Error of a bus operation.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum BusError {
    /// Another server is registered at this address.
    #[error("`{address}` is served already")]
    Served {
        /// Address as the caller wrote it.
        address: String,
    },
    /// The transport is not there, and the topic's outage policy keeps nothing more; it is counted.
    #[error("no connection: {reason}")]
    Disconnected {
        /// Cause, in the transport's words.
        reason: String,
    },
    /// The transport does not let us.
    #[error("refused: {reason}")]
    Refused {
        /// Cause, in the transport's words.
        reason: String,
    },
    /// A name that the transport cannot carry.
    #[error("`{name}` cannot name a topic or an address: {reason}")]
    BadName {
        /// Rejected name.
        name: String,
        /// Limit that the name exceeds.
        reason: String,
    },
}
