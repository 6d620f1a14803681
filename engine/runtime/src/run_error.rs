//! Errors of operations on a running system.

use asmotion_component::{LifeCycleError, PropertyError, suggestion};
use asmotion_datum::DatumError;

/// An error of an operation on a running system.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum RunError {
    /// A name that no component, input or topic has.
    #[error("unknown {kind} `{name}`{}", suggestion(nearest.as_deref()))]
    Unknown {
        /// The kind of thing looked for: component, input or topic.
        kind: &'static str,
        /// The name that was looked for.
        name: String,
        /// A similar name that exists, as a suggestion.
        nearest: Option<String>,
    },
    /// The sample has another type than the port.
    #[error("`{target}` takes {expected}: {source}")]
    Mismatch {
        /// The port, as `component.port`, or the topic.
        target: String,
        /// Name of the port's type.
        expected: String,
        /// The first difference between the sample and the port's type.
        source: Box<DatumError>,
    },
    /// A value that the property does not accept.
    #[error(transparent)]
    Property(#[from] PropertyError),
    /// The component's current state does not allow the transition.
    #[error(transparent)]
    LifeCycle(#[from] LifeCycleError),
    /// The component did not reply in time: its cycle is still under way.
    #[error("`{component}` is busy")]
    Busy {
        /// Name of the component.
        component: String,
    },
}
