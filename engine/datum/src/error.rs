//! Errors about data, with their place.

use std::fmt;

/// A problem with a datum, and its place in the datum.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[error("{}{problem}", PathPrefix(path))]
pub struct DatumError {
    /// Path to the place, outermost first, for example `poses.3.x`. Empty for the whole datum.
    pub path: String,
    /// The problem at this place.
    pub problem: DatumProblem,
}

/// A problem with a datum.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum DatumProblem {
    /// The expected type needs another kind of data or another value.
    #[error("{0}")]
    Mismatch(String),
    /// The value has the right type, but cannot be meant, such as a position that is not finite.
    #[error("{0}")]
    Implausible(&'static str),
    /// The integer does not fit into a datum's 64-bit signed integer.
    #[error("the integer {0} does not fit into 64 signed bits")]
    IntegerTooBig(String),
    /// A map key that is not text, and so cannot name an entry of a record.
    #[error("the keys of a record must be strings")]
    KeyNotText,
    /// The bytes are not valid for the codec.
    #[error("malformed {codec}: {reason}")]
    Malformed {
        /// Name of the codec.
        codec: &'static str,
        /// The decoder's error message.
        reason: String,
    },
    /// The codec cannot encode data of this schema.
    #[error("{codec} cannot carry {shape}")]
    Uncarried {
        /// Name of the codec.
        codec: &'static str,
        /// Description of the part that it cannot encode.
        shape: String,
    },
    /// The data are nested too deep. The limit protects the stack against hostile input.
    #[error("nested deeper than {0} levels")]
    TooDeep(usize),
}

impl DatumError {
    /// A problem with the whole datum; see [`DatumError::within`].
    pub fn new(problem: DatumProblem) -> Self {
        Self {
            path: String::new(),
            problem,
        }
    }

    /// The same problem as seen from one level further out.
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

/// The error of a record with a repeated name.
pub(crate) fn repeated_name(name: &str) -> DatumError {
    DatumError::new(DatumProblem::Mismatch(format!(
        "the field `{name}` occurs twice"
    )))
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

/// Displays `poses.3.x: ` before a message, or nothing for an empty path.
struct PathPrefix<'a>(&'a str);

impl fmt::Display for PathPrefix<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.0.is_empty() {
            return Ok(());
        }
        write!(f, "`{}`: ", self.0)
    }
}
