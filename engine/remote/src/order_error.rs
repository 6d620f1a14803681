//! Why an order is not carried out: at the system as facts, on the wire as a code.

use asmotion_datum::DatumError;
use asmotion_runtime::RunError;

/// Why an order is not carried out.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum OrderError {
    /// What the system refuses.
    #[error(transparent)]
    Run(#[from] RunError),
    /// The component has no such port.
    #[error("`{component}` has no port `{port}`; it has {known}")]
    Port {
        /// The component.
        component: String,
        /// The port asked for.
        port: String,
        /// Those it has.
        known: String,
    },
    /// An input to be read, or an output to be written.
    #[error("`{port}` is an {is}: {instead}")]
    Direction {
        /// `Component.port`.
        port: String,
        /// What it is.
        is: &'static str,
        /// What can be done with it.
        instead: &'static str,
    },
    /// Nothing has left the port yet.
    #[error("nothing has left `{port}` yet")]
    NoData {
        /// `Component.port`.
        port: String,
    },
    /// What would be answered has no form.
    #[error(transparent)]
    Datum(#[from] DatumError),
}

/// Why an order is not carried out, for programs.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum OrderErrorCode {
    /// The port takes another type.
    WrongType,
    /// The component has no such port.
    NoPort,
    /// An input to be read, or an output to be written.
    WrongDirection,
    /// Nothing has left the port yet.
    NoData,
    /// What would be answered has no form.
    NoForm,
    /// The order is none.
    BadRequest,
    /// The system refuses: another state, a property out of its range, no such component.
    Refused,
}

impl OrderErrorCode {
    /// All of them, with their codes.
    const CODES: [(Self, &'static str); 7] = [
        (Self::WrongType, "WRONG_TYPE"),
        (Self::NoPort, "NO_PORT"),
        (Self::WrongDirection, "WRONG_DIRECTION"),
        (Self::NoData, "NO_DATA"),
        (Self::NoForm, "NO_FORM"),
        (Self::BadRequest, "BAD_REQUEST"),
        (Self::Refused, "REFUSED"),
    ];

    /// Its code on the wire.
    pub fn code(self) -> &'static str {
        let known = Self::CODES.iter().find(|(reason, _)| *reason == self);
        known.map_or("REFUSED", |(_, code)| code)
    }

    /// The reason of a code; one that is not known is a refusal like others.
    pub fn of(code: &str) -> Self {
        let known = Self::CODES.iter().find(|(_, known)| *known == code);
        known.map_or(Self::Refused, |(reason, _)| *reason)
    }

    /// A refusal for this reason, explained.
    pub(crate) fn refusal(self, detail: impl ToString) -> asmotion_bus::Refusal {
        asmotion_bus::Refusal {
            code: self.code().to_owned(),
            detail: detail.to_string(),
        }
    }
}

impl OrderError {
    /// Why, for programs.
    pub fn reason(&self) -> OrderErrorCode {
        match self {
            Self::Run(RunError::Mismatch { .. }) => OrderErrorCode::WrongType,
            Self::Run(
                RunError::Unknown { .. }
                | RunError::Property(_)
                | RunError::LifeCycle(_)
                | RunError::Busy { .. },
            ) => OrderErrorCode::Refused,
            Self::Port { .. } => OrderErrorCode::NoPort,
            Self::Direction { .. } => OrderErrorCode::WrongDirection,
            Self::NoData { .. } => OrderErrorCode::NoData,
            Self::Datum(_) => OrderErrorCode::NoForm,
        }
    }
}
