//! Messages that a component was observed to receive and to send.

use asmotion_datum::Datum;
use std::fmt;

/// Messages that a component received and sent in one cycle.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ObservedCycle {
    /// Messages and requests that the cycle found, in order of arrival.
    pub received: Vec<ObservedMessage>,
    /// Messages, requests and answers that the cycle sent, in order.
    pub sent: Vec<ObservedMessage>,
}

/// A message, a request or an answer.
#[derive(Clone, Debug, PartialEq)]
pub struct ObservedMessage {
    /// Port or operation of the component.
    pub end: MessageEnd,
    /// The content; of an answer, the text `OK` or the code of the fault.
    pub content: Datum,
}

/// A port or an operation of a component.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum MessageEnd {
    /// A port.
    Port(String),
    /// An operation of a service or through a reference.
    Operation {
        /// Name of the service or reference.
        service: String,
        /// Name of the operation.
        operation: String,
    },
}

impl fmt::Display for MessageEnd {
    fn fmt(&self, to: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Port(port) => to.write_str(port),
            Self::Operation { service, operation } => write!(to, "{service}.{operation}"),
        }
    }
}

/// The first cycle of a component that its protocol does not allow.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum ProtocolDeviation {
    /// No resolution of the protocol's choices sends what the component sent.
    #[error(
        "cycle {cycle}: received {}; sent {}, where the protocol allows {}",
        listed(received),
        listed(sent),
        alternatives(allowed)
    )]
    NotAllowed {
        /// Number of the cycle, from 1.
        cycle: u64,
        /// Functions of the protocol with what the component received.
        received: Vec<String>,
        /// Functions of the protocol with what the component sent.
        sent: Vec<String>,
        /// Messages that the protocol could have sent instead, one list for each alternative.
        allowed: Vec<Vec<String>>,
    },
    /// A message has a value that the function of the protocol cannot have.
    #[error("cycle {cycle}: `{value}` at {end} is not a value of `{function}` in the protocol")]
    UnknownValue {
        /// Number of the cycle, from 1.
        cycle: u64,
        /// Port or operation.
        end: MessageEnd,
        /// Function of the protocol.
        function: String,
        /// The value, as text.
        value: String,
    },
    /// A message does not repeat the field that an `//@Echo` promises.
    #[error("cycle {cycle}: {output} has {sent}, where `//@Echo` promises {input}: {received}")]
    NoEcho {
        /// Number of the cycle, from 1.
        cycle: u64,
        /// Port and field of the message that was sent.
        output: String,
        /// Port and field of the message that was received.
        input: String,
        /// Content of the field that was sent.
        sent: String,
        /// Content of the field that was received, or that there was no message.
        received: String,
    },
    /// The protocol has no next state for what the component received.
    #[error(
        "cycle {cycle}: received {}; the protocol fails: {reason}",
        listed(received)
    )]
    ProtocolFails {
        /// Number of the cycle, from 1.
        cycle: u64,
        /// Functions of the protocol with what the component received.
        received: Vec<String>,
        /// The fault of the step.
        reason: String,
    },
}

fn listed(parts: &[String]) -> String {
    if parts.is_empty() {
        "nothing".to_owned()
    } else {
        parts.join(", ")
    }
}

fn alternatives(allowed: &[Vec<String>]) -> String {
    let each: Vec<String> = allowed.iter().map(|it| listed(it)).collect();
    each.join(", or ")
}
