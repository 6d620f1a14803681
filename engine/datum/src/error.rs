//! What can be wrong with a datum, and where in it.

use std::fmt;

/// A datum that does not fit: the place, and the problem there.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[error("{}{problem}", PathPrefix(path))]
pub struct DatumError {
    /// Path to the place, outermost first: `poses.3.x`. Empty for the whole.
    pub path: String,
    /// What is wrong there.
    pub problem: DatumProblem,
}

/// One way in which data does not fit.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum DatumProblem {
    /// The type asked for wants another kind of data, or another value.
    #[error("{0}")]
    Mismatch(String),
    /// A datum's integers have 64 bits and a sign.
    #[error("the integer {0} does not fit 64 bits with a sign")]
    IntegerTooBig(String),
    /// Only text can name the entries of a record.
    #[error("a record's keys are text")]
    KeyNotText,
    /// The bytes are not what the codec writes.
    #[error("malformed {codec}: {reason}")]
    Malformed {
        /// The codec that refused the bytes.
        codec: &'static str,
        /// Its reason.
        reason: String,
    },
    /// The codec has no way to write this.
    #[error("{codec} cannot carry {shape}")]
    Uncarried {
        /// The codec.
        codec: &'static str,
        /// What it cannot carry, in words.
        shape: String,
    },
    /// Data nested deeper than any message is; refused, so that a stack never overflows.
    #[error("nested deeper than {0} levels")]
    TooDeep(usize),
}

impl DatumError {
    /// A problem of the whole datum; see [`DatumError::within`].
    pub fn new(problem: DatumProblem) -> Self {
        Self {
            path: String::new(),
            problem,
        }
    }

    /// The same problem, seen from one level further out.
    #[must_use]
    pub fn within(mut self, segment: impl fmt::Display) -> Self {
        self.path = if self.path.is_empty() {
            segment.to_string()
        } else {
            format!("{segment}.{}", self.path)
        };
        self
    }
}

impl serde::ser::Error for DatumError {
    fn custom<T: fmt::Display>(message: T) -> Self {
        Self::new(DatumProblem::Mismatch(message.to_string()))
    }
}

impl serde::de::Error for DatumError {
    fn custom<T: fmt::Display>(message: T) -> Self {
        Self::new(DatumProblem::Mismatch(message.to_string()))
    }
}

/// `poses.3.x: ` in front of a message, or nothing for the whole.
struct PathPrefix<'a>(&'a str);

impl fmt::Display for PathPrefix<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.0.is_empty() {
            return Ok(());
        }
        write!(f, "`{}`: ", self.0)
    }
}
