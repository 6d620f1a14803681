//! What travels between caller and provider.

use std::sync::Arc;

use datum::Sample;

use super::{CallError, Mailbox};
use crate::Time;

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
    /// Where the answer goes; nowhere for a one-way call.
    pub answer_to: Option<Arc<Mailbox>>,
}

/// To a caller.
pub(crate) struct Answer {
    /// The call's number at the caller.
    pub number: u64,
    pub result: Result<Arc<dyn Sample>, CallError>,
}
