//! What can be wrong with a system's construction.

use asmotion_component::declaration::DeclarationError;
use asmotion_component::{PropertyError, suggestion};
use asmotion_datum::{DatumError, Schema, SchemaDifference};

/// Why a system cannot be built as asked.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum BuildError {
    /// A component's name that is empty or taken.
    #[error("`{name}` cannot be a component's name: it is empty or taken")]
    Name {
        /// The name.
        name: String,
    },
    /// The component's own declarations do not go together.
    #[error("component `{component}`: {source}")]
    Declaration {
        /// The component.
        component: String,
        /// What does not.
        source: DeclarationError,
    },
    /// Nothing of that name.
    #[error("there is no {what} `{name}`{}", suggestion(nearest.as_deref()))]
    Unknown {
        /// Component, input, output, service, reference.
        what: &'static str,
        /// The name asked for.
        name: String,
        /// A name like it.
        nearest: Option<String>,
    },
    /// A port, service or reference on the wrong side.
    #[error("`{end}` is {} {is}, not {} {wanted}", article(is), article(wanted))]
    Direction {
        /// The end.
        end: String,
        /// What it is.
        is: &'static str,
        /// What it would have to be.
        wanted: &'static str,
    },
    /// Two ends in two threads, and nothing to keep them apart.
    #[error(
        "`{from}` and `{to}` cycle in two threads, and their connection is `unsync`: make one the other's slave, or use a lock-free connection"
    )]
    Threads {
        /// The writing end.
        from: String,
        /// The reading end.
        to: String,
    },
    /// More threads than the connection allows.
    #[error("{threads} threads would use the queue of `{to}`, which allows {max}")]
    Crowded {
        /// The reading end.
        to: String,
        /// How many it would be.
        threads: usize,
        /// How many it may be.
        max: usize,
    },
    /// A queue in common that is of another kind.
    #[error(
        "`{from}` and `{to}` cannot have their queue in common with the others: those have {what}"
    )]
    OtherQueue {
        /// The writing end.
        from: String,
        /// The reading end.
        to: String,
        /// What the others have.
        what: &'static str,
    },
    /// No such connection.
    #[error("`{from}` is not connected to `{to}`")]
    NotJoined {
        /// The writing end.
        from: String,
        /// The reading end.
        to: String,
    },
    /// A component that would be its own master.
    #[error("`{slave}` cannot cycle after `{master}`: it would cycle after itself")]
    OwnMaster {
        /// The slave.
        slave: String,
        /// The master.
        master: String,
    },
    /// Two ends of different types.
    #[error("`{from}` and `{to}` differ: {difference}")]
    Types {
        /// The writing end, `component.port`, or the reference.
        from: String,
        /// The reading end, or the service.
        to: String,
        /// The first difference.
        difference: Box<SchemaDifference>,
    },
    /// Two ends of different interfaces.
    #[error("`{from}` requires {required}, `{to}` provides {provided}")]
    Interfaces {
        /// The reference.
        from: String,
        /// Its interface.
        required: String,
        /// The service.
        to: String,
        /// Its interface.
        provided: String,
    },
    /// An operation that the service lacks.
    #[error("`{from}` calls `{operation}`, which `{to}` does not serve")]
    Operation {
        /// The reference.
        from: String,
        /// The operation.
        operation: String,
        /// The service.
        to: String,
    },
    /// Joined already: a connection twice, a second topic for an output, a second service for a reference
    /// that waits for an answer.
    #[error("`{end}` is joined already: to {to}")]
    Joined {
        /// The end.
        end: String,
        /// To what.
        to: String,
    },
    /// The topic on which the system tells how its bus is.
    #[error("`{from}` cannot publish `{topic}`: there the system tells how its bus is")]
    OwnTopic {
        /// The writing end.
        from: String,
        /// The topic.
        topic: &'static str,
    },
    /// Zeros cannot stand for a stale sample of this type.
    #[error("`{to}` has no sample of zeros: {source}")]
    NoZero {
        /// The reading end.
        to: String,
        /// Why.
        source: DatumError,
    },
    /// A property that cannot have its value.
    #[error(transparent)]
    Property(#[from] PropertyError),
}

impl BuildError {
    /// Compares the types of two ends.
    pub(crate) fn compare(
        written: &Schema,
        from: &str,
        taken: &Schema,
        to: &str,
    ) -> Result<(), Self> {
        written.compare(taken).map_err(|difference| Self::Types {
            from: from.to_owned(),
            to: to.to_owned(),
            difference: Box::new(difference),
        })
    }
}

fn article(what: &str) -> &'static str {
    match what.starts_with(['i', 'o']) {
        true => "an",
        false => "a",
    }
}
