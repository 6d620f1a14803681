//! Errors of orders: an enum in the system, a code on the wire.

use asmotion_datum::DatumError;
use asmotion_runtime::RunError;

/// The reason that an order is not carried out.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum OrderError {
    /// The running system refuses the order.
    #[error(transparent)]
    Run(#[from] RunError),
    /// The component has no such port.
    #[error("`{component}` has no port `{port}`; it has {available}")]
    Port {
        /// Name of the component.
        component: String,
        /// The name that was looked for.
        port: String,
        /// Names of the component's ports.
        available: String,
    },
    /// An attempt to read an input or to write an output.
    #[error("`{port}` is an {actual}: {opposite}")]
    Direction {
        /// The port, as `Component.port`.
        port: String,
        /// Direction of the port: `input` or `output`.
        actual: &'static str,
        /// The operation that is possible instead.
        opposite: &'static str,
    },
    /// The output has not written anything yet.
    #[error("`{port}` has not written a sample yet")]
    NoData {
        /// The output, as `Component.port`.
        port: String,
    },
    /// The reply cannot be represented as data.
    #[error(transparent)]
    Datum(#[from] DatumError),
}

/// The reason that an order is not carried out, as a code for programs.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum OrderErrorCode {
    /// The port has another type.
    WrongType,
    /// The component has no such port.
    UnknownPort,
    /// An attempt to read an input or to write an output.
    WrongDirection,
    /// The output has not written anything yet.
    NoData,
    /// The reply cannot be represented as data.
    NotRepresentable,
    /// The order cannot be decoded.
    BadRequest,
    /// The running system refuses: wrong state, property out of range, no such component.
    Refused,
}

impl OrderErrorCode {
    /// All reasons with their codes on the wire.
    const CODES: [(Self, &'static str); 7] = [
        (Self::WrongType, "WRONG_TYPE"),
        (Self::UnknownPort, "NO_PORT"),
        (Self::WrongDirection, "WRONG_DIRECTION"),
        (Self::NoData, "NO_DATA"),
        (Self::NotRepresentable, "NO_FORM"),
        (Self::BadRequest, "BAD_REQUEST"),
        (Self::Refused, "REFUSED"),
    ];

    /// The code on the wire.
    pub fn code(self) -> &'static str {
        let known = Self::CODES.iter().find(|(reason, _)| *reason == self);
        known.map_or("REFUSED", |(_, code)| code)
    }

    /// The reason with this code; [`Refused`](Self::Refused) for an unknown code.
    pub fn of(code: &str) -> Self {
        let known = Self::CODES.iter().find(|(_, known)| *known == code);
        known.map_or(Self::Refused, |(reason, _)| *reason)
    }

    /// A refusal with this code and an explanation.
    pub(crate) fn refusal(self, detail: impl ToString) -> asmotion_bus::Refusal {
        asmotion_bus::Refusal {
            code: self.code().to_owned(),
            detail: detail.to_string(),
        }
    }
}

impl OrderError {
    /// The reason as a code.
    pub fn reason(&self) -> OrderErrorCode {
        match self {
            Self::Run(RunError::Mismatch { .. }) => OrderErrorCode::WrongType,
            Self::Run(
                RunError::Unknown { .. }
                | RunError::Property(_)
                | RunError::LifeCycle(_)
                | RunError::Busy { .. },
            ) => OrderErrorCode::Refused,
            Self::Port { .. } => OrderErrorCode::UnknownPort,
            Self::Direction { .. } => OrderErrorCode::WrongDirection,
            Self::NoData { .. } => OrderErrorCode::NoData,
            Self::Datum(_) => OrderErrorCode::NotRepresentable,
        }
    }
}
