//! What travels between caller and provider.

use std::sync::{Arc, mpsc};

use asmotion_bus::{Call, CallFailure, Payload, Refusal, Trace};
use asmotion_datum::Sample;

use super::{CallError, Mailbox};
use crate::Time;
use crate::outside::Outside;

/// Names one call in the system.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct CallKey {
    /// The caller's place in the system.
    pub caller: usize,
    /// The call's number at the caller.
    pub number: u64,
}

/// To a provider.
pub(crate) enum Post {
    Ask(Ask),
    /// The caller no longer waits.
    Cancel(CallKey),
}

/// A question with its return address.
pub(crate) struct Ask {
    pub key: CallKey,
    /// Position of the operation in the service.
    pub operation: usize,
    pub argument: Arc<dyn Sample>,
    pub caller: Arc<str>,
    pub deadline: Option<Time>,
    /// What it follows from.
    pub trace: Option<Trace>,
    /// Where the answer goes; nowhere for a one-way call.
    pub answer_to: Option<AnswerTo>,
}

/// Where an answer goes.
pub(crate) enum AnswerTo {
    /// To a component of this system.
    Here(Arc<Mailbox>),
    /// To a caller on the bus.
    Bus(Box<Call>),
    /// To somebody outside of the system.
    Outside(mpsc::Sender<Result<Arc<dyn Sample>, CallError>>),
}

impl AnswerTo {
    /// Whether the caller still waits, as far as that is known here.
    pub(crate) fn is_awaited(&self) -> bool {
        match self {
            // The one posts a cancellation when it does not, the other has a deadline.
            Self::Here(_) | Self::Outside(_) => true,
            Self::Bus(call) => call.is_awaited(),
        }
    }

    /// Answers the caller's call of this number.
    pub(crate) fn send(
        self,
        number: u64,
        result: Result<Arc<dyn Sample>, CallError>,
        outside: &mut dyn Outside,
    ) {
        match self {
            Self::Here(mailbox) => mailbox.put(Answer { number, result }, outside),
            // Whoever has lost patience does not read it.
            Self::Outside(answer) => drop(answer.send(result)),
            Self::Bus(call) => call.end(result.map(Payload::Sample).map_err(failure)),
        }
    }
}

/// An error as the bus carries it.
fn failure(error: CallError) -> CallFailure {
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

/// To a caller.
pub(crate) struct Answer {
    /// The call's number at the caller.
    pub number: u64,
    pub result: Result<Arc<dyn Sample>, CallError>,
}
