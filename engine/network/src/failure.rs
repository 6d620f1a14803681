//! Converts errors of calls between the component's and the bus' representation.

use asmotion_bus::{CallFailure, Refusal};
use asmotion_component::{CallError, ServiceFault};

/// Converts a failure on the bus to the calling component's error.
pub fn call_error(failure: CallFailure) -> CallError {
    match failure {
        CallFailure::Timeout => CallError::Timeout,
        CallFailure::Unavailable => CallError::Unavailable,
        CallFailure::Stopped => CallError::Stopped,
        CallFailure::Cancelled => CallError::Cancelled,
        CallFailure::Refused(refusal) => {
            CallError::Fault(ServiceFault::new(refusal.code, refusal.detail))
        }
    }
}

/// Converts a provider's error to a failure on the bus.
pub(crate) fn call_failure(error: CallError) -> CallFailure {
    match error {
        CallError::Timeout => CallFailure::Timeout,
        CallError::Unavailable => CallFailure::Unavailable,
        CallError::Stopped => CallFailure::Stopped,
        CallError::Cancelled => CallFailure::Cancelled,
        CallError::Fault(fault) => CallFailure::Refused(Refusal {
            code: fault.code,
            detail: fault.detail,
        }),
    }
}
