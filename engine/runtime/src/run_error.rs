//! What cannot be done to a running system.

use asmotion_component::{LifeCycleError, PropertyError, suggestion};
use asmotion_datum::DatumError;

/// Why something cannot be done to a running system.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum RunError {
    /// Nothing of that name.
    #[error("there is no {what} `{name}`{}", suggestion(nearest.as_deref()))]
    Unknown {
        /// Component, input or topic.
        what: &'static str,
        /// The name asked for.
        name: String,
        /// A name like it.
        nearest: Option<String>,
    },
    /// The sample is of another type than its place takes.
    #[error("`{place}` takes {expected}: {source}")]
    Mismatch {
        /// The port.
        place: String,
        /// What it takes.
        expected: String,
        /// What does not fit.
        source: Box<DatumError>,
    },
    /// A property cannot have its value.
    #[error(transparent)]
    Property(#[from] PropertyError),
    /// The component's life does not allow it.
    #[error(transparent)]
    LifeCycle(#[from] LifeCycleError),
    /// The component did not answer in time: its cycle is still under way.
    #[error("`{component}` is busy")]
    Busy {
        /// The component.
        component: String,
    },
}
