//! The trait that every bus implements.

use std::sync::Arc;
use std::time::Duration;

use asmotion_datum::Schema;

use crate::envelope::Payload;
use crate::health::Health;
use crate::pattern::Pattern;
use crate::publish_options::{PublishOptions, PublisherCounts};
use crate::queue::{QueuePolicy, Subscription};
use crate::request::{PendingCall, Request, ServedAddress};
use crate::sender_id::SenderId;
use crate::trace_context::TraceContext;
use asmotion_connection::Notifier;

/// A bus: topics and addresses shared by processes.
///
/// Between one publisher and one subscription messages keep their order; a subscription receives messages published
/// after it began. Publishing never waits for a subscriber.
pub trait Bus: Send + Sync {
    /// Creates a publisher on a topic, for messages of this schema. Types are compared when messages are read; all
    /// publishers of a topic should use the same type.
    ///
    /// # Errors
    /// [`BusError::InvalidName`] if the transport cannot use the topic as a name.
    fn publisher(
        &self,
        topic: &str,
        origin: &SenderId,
        schema: &Schema,
        sending: PublishOptions,
    ) -> Result<Box<dyn Publisher>, BusError>;

    /// Subscribes to all topics that match a pattern, from now on. `reader` is shown to operators; the notifier is
    /// notified of every message.
    ///
    /// # Errors
    /// [`BusError::InvalidName`] if the transport cannot express the pattern; [`BusError::Refused`] if the user may not
    /// read these topics.
    fn subscribe(
        &self,
        reader: &str,
        pattern: &Pattern,
        queue: QueuePolicy,
        notifier: Arc<Notifier>,
    ) -> Result<Subscription, BusError>;

    /// Provides a service at an address, which can have one provider at a time. At most `size` requests wait.
    ///
    /// # Errors
    /// [`BusError::Served`] if the address has a provider, [`BusError::InvalidName`] if the transport cannot use it as
    /// a name, [`BusError::Refused`] if the user may not provide it.
    fn serve(
        &self,
        address: &str,
        size: usize,
        notifier: Arc<Notifier>,
    ) -> Result<ServedAddress, BusError>;

    /// Sends a request to an address. The call ends with a reply or a [`CallFailure`](crate::CallFailure): at once if
    /// there is no provider, and at the deadline at the latest.
    ///
    /// # Errors
    /// [`BusError::InvalidName`] if the transport cannot carry the address; failures of the call itself arrive in the
    /// [`PendingCall`].
    fn call(
        &self,
        address: &str,
        request: Request,
        notifier: Arc<Notifier>,
    ) -> Result<PendingCall, BusError>;

    /// Sends a one-way request (SCA `@OneWay`). The call ends successfully once the provider's queue has the request,
    /// otherwise with a failure; drop the [`PendingCall`] to ignore both.
    ///
    /// # Errors
    /// As [`call`](Self::call).
    fn call_one_way(
        &self,
        address: &str,
        request: Request,
        notifier: Arc<Notifier>,
    ) -> Result<PendingCall, BusError>;

    /// Sends again the last message of each publisher that [retains it](PublishOptions::init), with its original
    /// number: late subscribers receive it, all others discard it as a duplicate.
    fn republish_retained(&self);

    /// Returns the state of the transport.
    fn health(&self) -> Health;

    /// Notifies `notifier` of every change of [`health`](Self::health) until all other references to it have been
    /// dropped.
    fn notify_on_change(&self, notifier: &Arc<Notifier>);

    /// Waits until all messages have been sent and, if requested, confirmed. Returns `false` if `timeout` passes first.
    fn drain(&self, timeout: Duration) -> bool;
}

/// Publishes on one topic, and numbers the messages from 1.
pub trait Publisher: Send {
    /// Publishes a message. `stamp` is the time of sending, in nanoseconds of the sender's clock. Never blocks.
    ///
    /// # Errors
    /// As [`publish_traced`](Self::publish_traced).
    fn publish(&mut self, stamp: i64, payload: Payload) -> Result<(), BusError> {
        self.publish_traced(stamp, payload, None)
    }

    /// Publishes a message that continues the trace of its cause. Without a cause, it begins a trace.
    ///
    /// # Errors
    /// [`BusError::Disconnected`] if the message is dropped because the outbox is full while the link is down or slow.
    fn publish_traced(
        &mut self,
        stamp: i64,
        payload: Payload,
        cause: Option<TraceContext>,
    ) -> Result<(), BusError>;

    /// Returns the counts of messages by outcome.
    fn counts(&self) -> PublisherCounts;
}

/// Error of a bus operation.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum BusError {
    /// Another provider is registered at this address.
    #[error("`{address}` is already served")]
    Served {
        /// Address as the caller wrote it.
        address: String,
    },
    /// The transport is down, and the topic's outage policy keeps no more messages. The message is counted as dropped.
    #[error("no connection: {reason}")]
    Disconnected {
        /// Cause, in the transport's words.
        reason: String,
    },
    /// The transport refuses the operation, for example for lack of permission.
    #[error("refused: {reason}")]
    Refused {
        /// Cause, in the transport's words.
        reason: String,
    },
    /// A name that the transport cannot represent.
    #[error("invalid topic or address `{name}`: {reason}")]
    InvalidName {
        /// Rejected name.
        name: String,
        /// Limit that the name exceeds.
        reason: String,
    },
}
