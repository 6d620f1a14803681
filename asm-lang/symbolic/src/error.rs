//! Reasons for which states cannot be represented by decision diagrams.

use asmotion_lang::ir::{FunctionId, Origin};

/// The reason for which a symbolic verification cannot continue.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum SymbolicError {
    /// The memory is full.
    Memory,
    /// The caller ended it.
    Stopped,
    /// A construct that has no representation.
    Unsupported {
        /// Place of the construct.
        origin: Origin,
        /// The construct, as the subject of a sentence.
        construct: String,
    },
    /// The values of an input cannot be enumerated.
    Input {
        /// Place at which it is read.
        origin: Origin,
        /// Monitored or shared function without a finite range.
        function: FunctionId,
    },
}

impl SymbolicError {
    pub(crate) fn unsupported(origin: Origin, construct: impl Into<String>) -> Self {
        Self::Unsupported {
            origin,
            construct: construct.into(),
        }
    }
}
