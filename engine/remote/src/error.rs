//! Errors of operations on a remote system.

#[cfg(feature = "amqp")]
use asmotion_amqp::AddressError;
use asmotion_bus::{BusError, Refusal};
use asmotion_component::{CallError, suggestion};
use asmotion_datum::DatumError;

use crate::order_error::OrderErrorCode;

/// An error of an operation on a remote system.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum RemoteError {
    /// The broker's address is invalid.
    #[cfg(feature = "amqp")]
    #[error(transparent)]
    Address(#[from] AddressError),
    /// The bus is unavailable or refuses the operation.
    #[error(transparent)]
    Bus(#[from] BusError),
    /// A name that no component, service or property has.
    #[error("unknown {what} `{name}`{}", suggestion(nearest.as_deref()))]
    Unknown {
        /// The kind of thing looked for: component, service or property.
        what: &'static str,
        /// The name that was looked for.
        name: String,
        /// A similar name that exists, as a suggestion.
        nearest: Option<String>,
    },
    /// Several components have this name.
    #[error("ambiguous name `{name}`: {}", candidates.join(", "))]
    Several {
        /// The ambiguous name.
        name: String,
        /// The full names of the candidates.
        candidates: Vec<String>,
    },
    /// The component's process refuses an order.
    #[error("{detail}")]
    Refused {
        /// The reason, for programs.
        reason: OrderErrorCode,
        /// The explanation, for a human reader.
        detail: String,
    },
    /// The component is in a cycle that does not end, and cannot be asked meanwhile.
    #[error(
        "`{component}` is in a cycle that does not end, and its properties cannot be read meanwhile"
    )]
    Busy {
        /// Full name of the component.
        component: String,
    },
    /// The component's process did not reply to an order.
    #[error("the process `{process}` does not respond: {source}")]
    Process {
        /// Name of the process.
        process: String,
        /// The reason that there was no reply.
        source: CallError,
    },
    /// An operation that no process provides.
    #[error("unknown operation `{operation}`{}", suggestion(nearest.as_deref()))]
    Nobody {
        /// The address that was called.
        operation: String,
        /// A similar operation that exists, as a suggestion.
        nearest: Option<String>,
    },
    /// An operation whose component does not run, and does not answer it while stopped.
    #[error("`{operation}`: {} does not run", component.as_ref().map_or_else(|| "the component that provides it".to_owned(), |name| format!("component `{name}`")))]
    Stopped {
        /// The address that was called.
        operation: String,
        /// Full name of the component, if its presence is known.
        component: Option<String>,
    },
    /// A call ended without a response.
    #[error(transparent)]
    Call(#[from] CallError),
    /// A value does not have the expected type.
    #[error(transparent)]
    Datum(#[from] DatumError),
}

impl From<Refusal> for RemoteError {
    fn from(refusal: Refusal) -> Self {
        Self::Refused {
            reason: OrderErrorCode::of(&refusal.code),
            detail: refusal.detail,
        }
    }
}
