//! Events of a bus that no call returns, for a log.

use std::fmt;
use std::time::Duration;

/// An event in the life of a bus.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum BusNotice {
    /// Connected, and all queues and exchanges are declared.
    Connected {
        /// Address of the broker.
        broker: String,
    },
    /// The connection was lost, or could not be opened.
    Disconnected {
        /// Cause, for display.
        reason: String,
    },
    /// The broker accepts no messages.
    Blocked,
    /// The broker accepts messages again.
    Unblocked,
    /// The broker closed a channel or deleted a queue, which is declared again.
    Refused {
        /// The topic, pattern or address concerned.
        what: String,
        /// Cause, in the broker's words.
        reason: String,
    },
    /// A message could not be decoded.
    Unreadable {
        /// Topic or address of the message.
        what: String,
        /// Decoding error.
        reason: String,
    },
    /// The numbers of a stream jumped too far for a loss: its publisher is faulty, or its messages are forged.
    SequenceJump {
        /// Topic of the message.
        topic: String,
        /// The sender's AMQP user, which the broker verifies; empty if the message names none.
        user: String,
        /// The highest number before.
        from: u64,
        /// The number of the message.
        to: u64,
    },
    /// A request came so late that its caller has given up; it was not executed.
    Late {
        /// Address of the request.
        what: String,
        /// Name of the caller.
        source: String,
    },
    /// The clock of a caller differs from that of this machine by more than a timeout.
    ClockOffset {
        /// Name of the caller.
        source: String,
        /// Difference of the clocks.
        difference: Duration,
    },
    /// Messages that a publisher had accepted did not reach the broker, or were not accepted by it.
    Undelivered {
        /// Topic of the messages.
        what: String,
        /// Number of such messages so far.
        losses: PublisherLosses,
    },
    /// A message could not be encoded.
    Unwritable {
        /// Topic or address of the message.
        what: String,
        /// Encoding error.
        reason: String,
    },
}

/// Messages that a publisher lost after it had accepted them, by cause.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct PublisherLosses {
    /// Messages that waited for the broker until they were too old for all readers.
    pub expired: u64,
    /// Messages that the broker rejected, because a reader's queue was full or the publisher may not write there.
    pub refused: u64,
}

impl fmt::Display for PublisherLosses {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match (self.expired, self.refused) {
            (expired, 0) => write!(f, "{expired} waited until they were too old"),
            (0, refused) => write!(f, "the broker rejected {refused}"),
            (expired, refused) => write!(
                f,
                "{expired} waited until they were too old, and the broker rejected {refused}"
            ),
        }
    }
}

impl fmt::Display for BusNotice {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Connected { broker } => write!(f, "connected to {broker}"),
            Self::Disconnected { reason } => write!(f, "no connection: {reason}"),
            Self::Blocked => f.write_str("the broker accepts no messages"),
            Self::Unblocked => f.write_str("the broker accepts messages again"),
            Self::Refused { what, reason } => write!(f, "`{what}` was refused: {reason}"),
            Self::Unreadable { what, reason } => {
                write!(f, "cannot decode a message on `{what}`: {reason}")
            }
            Self::SequenceJump {
                topic,
                user,
                from,
                to,
            } => write!(
                f,
                "the numbers of a stream of user `{user}` on `{topic}` jump from {from} to {to}"
            ),
            Self::Late { what, source } => write!(
                f,
                "a request of `{source}` to `{what}` came too late and was not executed"
            ),
            Self::ClockOffset { source, difference } => write!(
                f,
                "the clock of `{source}` differs from that of this machine by {:.1} s: synchronise them",
                difference.as_secs_f64()
            ),
            Self::Undelivered { what, losses } => {
                write!(f, "messages on `{what}` were not delivered: {losses}")
            }
            Self::Unwritable { what, reason } => {
                write!(f, "cannot encode a message for `{what}`: {reason}")
            }
        }
    }
}
