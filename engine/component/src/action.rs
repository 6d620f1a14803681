//! The journal of a cycle: the actions that are carried out when the cycle is committed.

use std::sync::Arc;
use std::time::Duration;

use asmotion_datum::{Datum, Sample};
use asmotion_port::Time;

use crate::operation::{CallId, OperationSlot, RequestId, ServiceFault};

/// An action of a cycle. Carried out in order when the cycle is committed, and dropped if the cycle fails.
pub enum CycleAction {
    /// Sends the oldest pending sample of the output port at this position.
    Write(usize),
    /// Calls an operation.
    Call {
        /// The operation, among the component's references.
        slot: OperationSlot,
        /// The call's number, as returned by `next_call` of the host.
        call: CallId,
        /// The request, in the caller's type.
        argument: Arc<dyn Sample>,
        /// `true` if the call has no reply.
        one_way: bool,
    },
    /// Cancels a call.
    Cancel(CallId),
    /// Replies to a request.
    Answer {
        /// Position of the service in the component.
        service: usize,
        /// The request to reply to.
        to: RequestId,
        /// The response, or the fault that takes its place.
        result: Result<Arc<dyn Sample>, ServiceFault>,
    },
    /// Reports data of this kind to the observers.
    Report(&'static str, Datum),
    /// Counts a sample of the input port at this position that the component refused, and reports the cause if it is new.
    Refuse(usize, String),
    /// Changes the component's period; zero makes it event-driven.
    SetPeriod(Duration),
    /// Triggers the component itself, if it is event-driven.
    CycleAgain,
    /// Triggers the component itself at this time, if it is event-driven.
    CycleAt(Time),
}
