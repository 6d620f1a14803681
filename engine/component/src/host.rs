//! What a runtime provides to a component in its hooks.

use std::sync::Arc;
use std::time::Duration;

use asmotion_datum::Sample;
use asmotion_port::{AnyInput, AnyOutput, Time};

use crate::action::CycleAction;
use crate::background::WorkPlace;
use crate::losses::Losses;
use crate::operation::{CallId, OperationSlot, Reply, RequestId};
use crate::property::AnyProperty;

/// The properties of a component, as [`Setup`](crate::Setup) shows them.
pub trait PropertyHost {
    /// The interface that the component's handles were declared on.
    fn owner(&self) -> u32;

    /// The property at this position.
    fn property(&self, index: usize) -> Option<&dyn AnyProperty>;
}

/// A component's ports, calls and requests during one cycle, as [`Cycle`](crate::Cycle) shows them. Positions are those
/// of the tables in [`InterfaceParts`](crate::InterfaceParts).
pub trait CycleHost: PropertyHost {
    /// The input port at this position, frozen for the cycle.
    fn input(&self, index: usize) -> Option<&dyn AnyInput>;

    /// The output port at this position.
    fn output(&mut self, index: usize) -> Option<&mut dyn AnyOutput>;

    /// The operation that a `Provided` handle stands for.
    fn provided(&self, index: usize) -> Option<OperationSlot>;

    /// The operation that a `Required` handle stands for.
    fn required(&self, index: usize) -> Option<OperationSlot>;

    /// Adds an action to the journal.
    fn record(&mut self, action: CycleAction);

    /// Takes the requests that wait for an operation.
    fn take_requests(&mut self, operation: OperationSlot) -> Vec<WaitingRequest>;

    /// The taken requests of a service that no caller waits for any more.
    fn cancelled(&self, service: usize) -> &[RequestId];

    /// A number for the next call.
    fn next_call(&mut self) -> CallId;

    /// Takes the ended calls of an operation.
    fn take_replies(&mut self, operation: OperationSlot) -> Vec<Reply<Arc<dyn Sample>>>;

    /// Takes one call of an operation, if it has ended.
    fn take_reply(
        &mut self,
        operation: OperationSlot,
        call: CallId,
    ) -> Option<Reply<Arc<dyn Sample>>>;

    /// Whether a call has been made and its end cannot be seen yet.
    fn is_under_way(&self, call: CallId) -> bool;

    /// Publishes the component's count of lost messages.
    fn set_losses(&mut self, losses: Losses);

    /// Where the component's background work runs.
    fn work_place(&self) -> &WorkPlace;

    /// Sets how long the cycle's work takes in simulated time.
    fn set_duration(&mut self, duration: Duration);

    /// Whether the component is to stop, and its activity lets a cycle be interrupted.
    fn is_interrupted(&self) -> bool;
}

/// A request that waits for its provider's cycle.
pub struct WaitingRequest {
    /// To be named in the reply.
    pub id: RequestId,
    /// The argument, in the caller's type.
    pub argument: Arc<dyn Sample>,
    /// The caller's name.
    pub caller: Arc<str>,
    /// When the caller gives up; absent for a one-way call.
    pub deadline: Option<Time>,
}
