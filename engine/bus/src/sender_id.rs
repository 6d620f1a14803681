//! Publishers and callers.

use std::sync::Arc;

/// Identity of a publisher or caller.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub struct SenderId {
    /// Name of the component.
    pub source: Arc<str>,
    /// Number of its process's current run; grows with every restart.
    pub incarnation: u64,
}

impl SenderId {
    /// Creates an identity from the component's name and the number of the process's run.
    pub fn new(source: impl Into<Arc<str>>, incarnation: u64) -> Self {
        Self {
            source: source.into(),
            incarnation,
        }
    }
}
