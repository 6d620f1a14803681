//! Faults of components at run time.

use std::any::Any;
use std::fmt;
use std::time::Duration;

use asmotion_port::Time;
use serde::{Deserialize, Serialize};

/// The reason that a component failed. `?` converts any error into a fault; [`Fault::new`] makes one from a message.
///
/// `Fault` does not implement `Error` itself, because that would conflict with the conversion from every error type.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Fault {
    /// The component returned an error, with this message.
    Failed(String),
    /// The component panicked, with this message.
    Panicked(String),
    /// The component used a handle that another component declared.
    ForeignHandle {
        /// The kind of the handle, for example `input` or `property`.
        kind: String,
    },
    /// Components triggered each other endlessly at one instant.
    Loop {
        /// The instant of the loop.
        at: Time,
        /// Names of the components in the loop.
        components: Vec<String>,
    },
    /// A cycle missed periods, and the activity's overrun policy is to fail.
    Overrun {
        /// Number of missed periods.
        missed: u64,
    },
    /// A cycle exceeded its deadline, and the activity's reaction is to fail.
    Late {
        /// Duration of the cycle.
        took: Duration,
        /// Limit on the duration.
        deadline: Duration,
    },
    /// A mandatory connection was full or could not carry the sample.
    NotDelivered {
        /// Name of the output port.
        port: String,
        /// Reading end of the connection, for example `Follower.path`.
        to: String,
    },
}

impl Fault {
    /// A fault with a message: lower case, no full stop.
    pub fn new(message: impl fmt::Display) -> Self {
        Self::Failed(message.to_string())
    }

    /// The fault of a caught panic, with the panic's message if it is text.
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
            Self::Overrun { missed: 1 } => f.write_str("missed a period"),
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
