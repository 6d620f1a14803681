//! What cannot be done from outside.

#[cfg(feature = "amqp")]
use asmotion_amqp::AddressError;
use asmotion_bus::{BusError, Refusal};
use asmotion_component::CallError;
use asmotion_datum::DatumError;

use crate::order_error::OrderErrorCode;

/// What cannot be done from outside.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum RemoteError {
    /// The broker's address is none.
    #[cfg(feature = "amqp")]
    #[error(transparent)]
    Address(#[from] AddressError),
    /// The bus is not there, or does not let us.
    #[error(transparent)]
    Bus(#[from] BusError),
    /// Nothing of that name.
    #[error("no {what} `{name}` is there{}", meant(nearest.as_deref()))]
    Unknown {
        /// Component, service, property.
        what: &'static str,
        /// The name asked for.
        name: String,
        /// A name like it.
        nearest: Option<String>,
    },
    /// Several components have that name.
    #[error("which `{name}`? {}", candidates.join(", "))]
    Several {
        /// The name asked for.
        name: String,
        /// Their whole names.
        candidates: Vec<String>,
    },
    /// The component's process does not carry out an order.
    #[error("{detail}")]
    Refused {
        /// Why, for programs.
        reason: OrderErrorCode,
        /// For people.
        detail: String,
    },
    /// The component's process does not answer.
    #[error("the process `{process}` does not answer: {source}")]
    Process {
        /// Which.
        process: String,
        /// How the order ended.
        source: CallError,
    },
    /// Nobody serves an operation.
    #[error("nobody serves `{operation}`{}", meant(nearest.as_deref()))]
    Nobody {
        /// Where it was called.
        operation: String,
        /// An operation like it.
        nearest: Option<String>,
    },
    /// A call has no response.
    #[error(transparent)]
    Call(#[from] CallError),
    /// A value has not the form that is wanted.
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

fn meant(nearest: Option<&str>) -> String {
    nearest.map_or_else(String::new, |name| format!("; did you mean `{name}`?"))
}
