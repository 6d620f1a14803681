//! Errors of nodes, endpoints and calls.

use std::time::Duration;

use asmotion_datum::DatumError;
use asmotion_ros_interface::{DefinitionError, InterfaceName};

use crate::names::NameError;

/// A node cannot be started.
#[derive(Debug, thiserror::Error)]
pub enum NodeError {
    /// The name or the namespace is not valid.
    #[error(transparent)]
    Name(#[from] NameError),
    /// The domain id has no ports.
    #[error("{0} is not a domain id: choose a number from 0 to 232")]
    Domain(u16),
    /// A node of the participant has the name.
    #[error("the participant has a node `{0}` already")]
    Twice(String),
    /// DDS refuses the participant, for example because no port is free.
    #[error("no participant of DDS in domain {domain}: {reason}")]
    Participant {
        /// The domain id.
        domain: u16,
        /// The reason that DDS gives.
        reason: String,
    },
    /// An endpoint that every node has, such as the publisher of the graph, cannot be created.
    #[error(transparent)]
    Endpoint(#[from] EndpointError),
    /// The operating system refuses a thread or an event queue.
    #[error("the thread of the node cannot be started: {0}")]
    Thread(#[from] std::io::Error),
}

/// A publisher, subscription, client or server cannot be created.
#[derive(Debug, thiserror::Error)]
pub enum EndpointError {
    /// The name is not that of a topic or service.
    #[error(transparent)]
    Name(#[from] NameError),
    /// The type is not defined.
    #[error(transparent)]
    Definition(#[from] DefinitionError),
    /// The type is of another kind, such as a service where a message is needed.
    #[error("`{of}` is no {needed}")]
    Kind {
        /// The name of the type.
        of: InterfaceName,
        /// The kind that is needed.
        needed: &'static str,
    },
    /// CDR cannot encode the type.
    #[error("messages of `{of}` cannot be sent: {reason}")]
    Uncarried {
        /// The name of the type.
        of: InterfaceName,
        /// The part that cannot be encoded.
        reason: DatumError,
    },
    /// DDS refuses the endpoint.
    #[error("DDS refuses `{topic}`: {reason}")]
    Dds {
        /// The topic of DDS.
        topic: String,
        /// The reason that DDS gives.
        reason: String,
    },
}

/// A message cannot be sent.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum SendError {
    /// The datum does not fit the schema of the type.
    #[error(transparent)]
    Datum(#[from] DatumError),
    /// DDS refuses the message.
    #[error("DDS refuses a message on `{topic}`: {reason}")]
    Dds {
        /// The topic of DDS.
        topic: String,
        /// The reason that DDS gives.
        reason: String,
    },
}

/// A call ended without a response.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum CallError {
    /// The request does not fit the schema of the service.
    #[error("the request does not fit the service: {0}")]
    Request(DatumError),
    /// No server had been found at the deadline. The request was not sent.
    #[error("no server of `{service}` was found within {deadline:?}")]
    NoServer {
        /// The service.
        service: String,
        /// The time that the caller allowed.
        deadline: Duration,
    },
    /// The request was sent, and no response came before the deadline.
    #[error("`{service}` did not respond within {deadline:?}")]
    Deadline {
        /// The service.
        service: String,
        /// The time that the caller allowed.
        deadline: Duration,
    },
    /// The response is not one of the service. The peer may use another mapping of services.
    #[error("`{service}` sent a response that cannot be read: {reason}")]
    Malformed {
        /// The service.
        service: String,
        /// The error of the decoder.
        reason: String,
    },
    /// As many calls wait as the client permits.
    #[error("{0} calls of `{1}` already wait for a response")]
    TooMany(usize, String),
    /// DDS refuses the request.
    #[error("the request cannot be sent: {0}")]
    Send(SendError),
}
