//! The end of a call that has no response: as components see it, and as a bus carries it.

use asmotion_bus::{CallFailure, Refusal};
use asmotion_component::{CallError, ServiceFault};

/// A failure on the bus, as the caller's component sees it.
pub fn call_error(failure: CallFailure) -> CallError {
    match failure {
        CallFailure::Timeout => CallError::Timeout,
        CallFailure::Unavailable => CallError::Unavailable,
        CallFailure::Cancelled => CallError::Cancelled,
        CallFailure::Refused(refusal) => {
            CallError::Fault(ServiceFault::new(refusal.code, refusal.detail))
        }
    }
}

/// An error of a provider, as the bus carries it.
pub(crate) fn call_failure(error: CallError) -> CallFailure {
    match error {
        CallError::Timeout => CallFailure::Timeout,
        CallError::Unavailable => CallFailure::Unavailable,
        CallError::Cancelled => CallFailure::Cancelled,
        CallError::Fault(fault) => CallFailure::Refused(Refusal {
            code: fault.code,
            detail: fault.detail,
        }),
    }
}
