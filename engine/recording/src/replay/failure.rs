//! The reasons that a coordinator cannot be replayed.

/// The reason that the steps of a coordinator cannot be repeated.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum ReplayFailure {
    /// A source text of the specification is not attached.
    #[error("the text of `{path}` is not attached to the recording")]
    NoSource {
        /// Path of the text in the run.
        path: String,
    },
    /// The attached specification has errors: another version of asmotion has recorded it.
    #[error("its specification cannot be opened:\n{reason}")]
    Specification {
        /// The rendered errors.
        reason: String,
    },
    /// The safe rule or a property of the composite does not fit the specification.
    #[error("what was watched does not fit the specification: {reason}")]
    Watch {
        /// The first error.
        reason: String,
    },
    /// The initial state cannot be computed.
    #[error("it has no initial state: {reason}")]
    Initial {
        /// Message of the fault.
        reason: String,
    },
    /// An agent that stands for a service does not exist.
    #[error("`{agent}`, which stands for a service, does not exist in the specification")]
    Agent {
        /// The agent as text.
        agent: String,
    },
    /// The machine continued from a frozen state.
    #[error(
        "it continued from a frozen state, which the recording does not contain: record the run from its beginning"
    )]
    Frozen,
    /// The state of the predecessor does not fit.
    #[error(
        "its specification was replaced at {} s, and the state does not fit the new version: {reason}",
        *time_ns as f64 / 1e9
    )]
    Transfer {
        /// Time of the replacement.
        time_ns: i64,
        /// The first value that does not fit.
        reason: String,
    },
}
