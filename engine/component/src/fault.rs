//! What goes wrong at run time.

use std::any::Any;
use std::fmt;
use std::time::Duration;

use asmotion_port::Time;
use serde::{Deserialize, Serialize};

/// Why a component failed. Any error becomes one with `?`; for words alone there is [`Fault::new`].
///
/// Not an error type itself, so that `?` can make one of every error that is.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Fault {
    /// The component said so.
    Failed(String),
    /// The component panicked, with this message.
    Panicked(String),
    /// A handle was used that another component declared.
    ForeignHandle {
        /// What the handle stands for: `input`, `property`.
        kind: String,
    },
    /// Components triggered each other without end at one instant.
    Loop {
        /// The instant.
        at: Time,
        /// Those in the loop, by name.
        components: Vec<String>,
    },
    /// A cycle took longer than its period, and the activity forbids that.
    Overrun {
        /// How many periods were missed.
        missed: u64,
    },
    /// A cycle took longer than its deadline, and the activity forbids that.
    Late {
        /// How long it took.
        took: Duration,
        /// How long it may take.
        deadline: Duration,
    },
    /// A mandatory connection was full, or could not carry the sample.
    NotDelivered {
        /// The output port.
        port: String,
        /// The connection's other end: `Follower.path`.
        to: String,
    },
}

impl Fault {
    /// A fault in words: lower case, no full stop.
    pub fn new(what: impl fmt::Display) -> Self {
        Self::Failed(what.to_string())
    }

    /// The fault of a caught panic, with its message if it has one.
    pub fn of_panic(payload: &(dyn Any + Send)) -> Self {
        let message = payload
            .downcast_ref::<&str>()
            .map(|text| (*text).to_owned())
            .or_else(|| payload.downcast_ref::<String>().cloned());
        Self::Panicked(message.unwrap_or_else(|| "no message".to_owned()))
    }
}

impl<E: std::error::Error> From<E> for Fault {
    fn from(error: E) -> Self {
        Self::new(error)
    }
}

impl fmt::Display for Fault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Failed(what) => f.write_str(what),
            Self::Panicked(what) => write!(f, "panicked: {what}"),
            Self::ForeignHandle { kind } => {
                write!(f, "a handle of another component's {kind} was used")
            }
            Self::Loop { at, components } => write!(
                f,
                "components trigger each other without end at {at}: {}",
                components.join(", ")
            ),
            Self::Overrun { missed } => write!(f, "missed {missed} periods"),
            Self::Late { took, deadline } => {
                write!(f, "a cycle took {took:?}, and has {deadline:?}")
            }
            Self::NotDelivered { port, to } => {
                write!(f, "`{port}` could not deliver to mandatory `{to}`")
            }
        }
    }
}
