//! What can be wrong with a system's construction.

use datum::{DatumError, Difference};

use crate::declaration::DeclarationError;
use crate::property::{PropertyError, suggestion};

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
    /// Two ends of different types.
    #[error("`{from}` and `{to}` differ: {difference}")]
    Types {
        /// The writing end, `component.port`, or the reference.
        from: String,
        /// The reading end, or the service.
        to: String,
        /// The first difference.
        difference: Box<Difference>,
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
