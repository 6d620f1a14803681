//! Errors in the construction of a system.

use asmotion_component::declaration::DeclarationError;
use asmotion_component::{PropertyError, suggestion};
use asmotion_datum::{DatumError, Schema, SchemaDifference};

/// An error in the construction of a system.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum BuildError {
    /// A component's name that is empty or taken.
    #[error("invalid component name `{name}`: it is empty or taken")]
    Name {
        /// The rejected name.
        name: String,
    },
    /// The component's declarations contradict each other.
    #[error("component `{component}`: {source}")]
    Declaration {
        /// Name of the component.
        component: String,
        /// The contradiction.
        source: DeclarationError,
    },
    /// A name that no component, port, service or reference has.
    #[error("unknown {kind} `{name}`{}", suggestion(nearest.as_deref()))]
    Unknown {
        /// The kind of thing looked for: component, input, output, service or reference.
        kind: &'static str,
        /// The name that was looked for.
        name: String,
        /// A similar name that exists, as a suggestion.
        nearest: Option<String>,
    },
    /// A port, service or reference on the wrong side.
    #[error(
        "`{end}` is {} {actual}, not {} {expected}",
        article(actual),
        article(expected)
    )]
    Direction {
        /// The end with the wrong direction, as `component.port`.
        end: String,
        /// The kind of this end.
        actual: &'static str,
        /// The kind needed here.
        expected: &'static str,
    },
    /// An `unsync` connection between two components that cycle in different threads.
    #[error(
        "`{from}` and `{to}` run in two threads, but their connection is `unsync`: make one the slave of the other, or use a lock-free connection"
    )]
    Threads {
        /// The writing end, as `component.port`.
        from: String,
        /// The reading end, as `component.port`.
        to: String,
    },
    /// More threads than the connection allows.
    #[error("{threads} threads use the queue of `{to}`, which allows {max}")]
    TooManyThreads {
        /// The reading end, as `component.port`.
        to: String,
        /// Number of threads that would use the queue.
        threads: usize,
        /// The connection's limit.
        max: usize,
    },
    /// A shared queue whose other connections have a different policy.
    #[error("`{from}` and `{to}` cannot share a queue with the others, which have {difference}")]
    QueueMismatch {
        /// The writing end, as `component.port`.
        from: String,
        /// The reading end, as `component.port`.
        to: String,
        /// The property in which the other connections differ.
        difference: &'static str,
    },
    /// The connection to remove does not exist.
    #[error("`{from}` is not connected to `{to}`")]
    NotConnected {
        /// The writing end, as `component.port`.
        from: String,
        /// The reading end, as `component.port`.
        to: String,
    },
    /// A component that would, directly or through others, be its own master.
    #[error("`{slave}` cannot run after `{master}`: it would run after itself")]
    MasterCycle {
        /// Name of the component that would be the slave.
        slave: String,
        /// Name of the component that would be its master.
        master: String,
    },
    /// Two ends of different types.
    #[error("`{from}` and `{to}` differ: {difference}")]
    TypeMismatch {
        /// The writing end, as `component.port`, or the reference.
        from: String,
        /// The reading end, or the service.
        to: String,
        /// The first difference.
        difference: Box<SchemaDifference>,
    },
    /// Two ends of different interfaces.
    #[error("`{from}` requires {required}, `{to}` provides {provided}")]
    InterfaceMismatch {
        /// The requiring end, as `component.reference`.
        from: String,
        /// The interface that the reference requires.
        required: String,
        /// The providing end, as `component.service`.
        to: String,
        /// The interface that the service provides.
        provided: String,
    },
    /// An operation that the service lacks.
    #[error("`{from}` calls `{operation}`, which `{to}` does not serve")]
    MissingOperation {
        /// The reference, as `component.reference`.
        from: String,
        /// Name of the operation.
        operation: String,
        /// The service, as `component.service`.
        to: String,
    },
    /// The end is connected already: the same connection twice, a second topic for an output, or a second service for a
    /// reference that waits for replies.
    #[error("`{end}` is already connected to {to}")]
    AlreadyConnected {
        /// The end that is connected already.
        end: String,
        /// The other end of the existing connection or wire.
        to: String,
    },
    /// An output that would publish on the topic reserved for the system's own bus health reports.
    #[error("`{from}` cannot publish `{topic}`: it is reserved for the state of the bus")]
    ReservedTopic {
        /// The writing end, as `component.port`.
        from: String,
        /// The reserved topic.
        topic: &'static str,
    },
    /// The policy replaces stale samples by zeros, but the port's type has no zero value.
    #[error("`{to}` has no sample of zeros: {source}")]
    NoZero {
        /// The reading end, as `component.port`.
        to: String,
        /// The part of the type that has no zero value.
        source: DatumError,
    },
    /// A safe sample that does not have the type of its output.
    #[error("the safe sample of `{output}` does not fit: {source}")]
    SafeSample {
        /// The output, as `component.port`.
        output: String,
        /// The first difference.
        source: DatumError,
    },
    /// A value that the property does not accept.
    #[error(transparent)]
    Property(#[from] PropertyError),
}

impl BuildError {
    /// Compares the types of two ends and returns the first difference as an error.
    pub(crate) fn compare(
        written: &Schema,
        from: &str,
        expected: &Schema,
        to: &str,
    ) -> Result<(), Self> {
        written
            .compare(expected)
            .map_err(|difference| Self::TypeMismatch {
                from: from.to_owned(),
                to: to.to_owned(),
                difference: Box::new(difference),
            })
    }
}

fn article(what: &str) -> &'static str {
    if what.starts_with(['i', 'o']) {
        "an"
    } else {
        "a"
    }
}
