//! The journal of a cycle: what it has done, to happen when the cycle is committed.

use std::sync::Arc;
use std::time::Duration;

use asmotion_datum::{Datum, Sample};

use crate::operation::{CallId, OperationSlot, RequestId, ServiceFault};

/// Something a cycle does. It happens when the cycle is committed, in order; a failed cycle's actions are dropped.
pub enum CycleAction {
    /// Sends the oldest pending sample of the output port at this position.
    Write(usize),
    /// Calls an operation.
    Call {
        /// The operation, among the component's references.
        slot: OperationSlot,
        /// The number that the component has been given.
        call: CallId,
        /// The request.
        argument: Arc<dyn Sample>,
        /// Whether the component wants no reply.
        one_way: bool,
    },
    /// Takes back a call.
    Cancel(CallId),
    /// Answers a request.
    Answer {
        /// Position of the service in the component.
        service: usize,
        /// The request.
        to: RequestId,
        /// The response, or why there is none.
        result: Result<Arc<dyn Sample>, ServiceFault>,
    },
    /// Tells the observers something of this kind.
    Report(&'static str, Datum),
    /// Changes the component's period.
    SetPeriod(Duration),
    /// Triggers the component itself, if it is event-driven.
    Again,
}
