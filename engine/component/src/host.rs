//! The interface between a component's hooks and its runtime.

use std::sync::Arc;
use std::time::Duration;

use asmotion_datum::Sample;
use asmotion_port::{AnyInput, AnyOutput, Time};

use crate::action::CycleAction;
use crate::background::WorkPlace;
use crate::losses::Losses;
use crate::operation::{CallId, OperationSlot, Reply, RequestId};
use crate::peer::PeerStatus;
use crate::property::AnyProperty;

/// The properties of a component, which [`Setup`](crate::Setup) reads.
pub trait PropertyHost {
    /// Number of the interface on which the component's handles were declared.
    fn owner(&self) -> u32;

    /// The property at this position.
    fn property(&self, index: usize) -> Option<&dyn AnyProperty>;
}

/// A component's ports, calls and requests during one cycle, which [`Cycle`](crate::Cycle) uses. Positions refer to the
/// tables in [`InterfaceParts`](crate::InterfaceParts).
pub trait CycleHost: PropertyHost {
    /// The input port at this position, frozen for the cycle.
    fn input(&self, index: usize) -> Option<&dyn AnyInput>;

    /// The output port at this position.
    fn output(&mut self, index: usize) -> Option<&mut dyn AnyOutput>;

    /// The operation that a `Provided` handle refers to.
    fn provided(&self, index: usize) -> Option<OperationSlot>;

    /// The operation that a `Required` handle refers to.
    fn required(&self, index: usize) -> Option<OperationSlot>;

    /// Adds an action to the journal.
    fn record(&mut self, action: CycleAction);

    /// Removes and returns the waiting requests of an operation.
    fn take_requests(&mut self, operation: OperationSlot) -> Vec<WaitingRequest>;

    /// The taken requests of a service whose callers no longer wait.
    fn cancelled(&self, service: usize) -> &[RequestId];

    /// Returns a fresh number for a call.
    fn next_call(&mut self) -> CallId;

    /// Removes and returns the ended calls of an operation.
    fn take_replies(&mut self, operation: OperationSlot) -> Vec<Reply<Arc<dyn Sample>>>;

    /// Removes and returns one call of an operation if it has ended.
    fn take_reply(
        &mut self,
        operation: OperationSlot,
        call: CallId,
    ) -> Option<Reply<Arc<dyn Sample>>>;

    /// Returns whether a call has been made and its end is not visible yet.
    fn is_under_way(&self, call: CallId) -> bool;

    /// Counts messages that the component dropped after they had arrived at the input port at this position.
    fn count_lost(&mut self, index: usize, count: u64);

    /// Publishes the component's count of lost messages.
    fn set_losses(&mut self, losses: Losses);

    /// The status of another component; `None` if the system has none with this name.
    fn peer(&self, component: &str) -> Option<PeerStatus>;

    /// Publishes whether what the component stands for can be reached.
    fn set_reachable(&mut self, is_reachable: bool);

    /// The thread in which the component's background work runs.
    fn work_place(&self) -> &WorkPlace;

    /// Sets the duration of the cycle in simulated time.
    fn set_duration(&mut self, duration: Duration);

    /// Returns whether the component is to stop and its activity allows the interruption of a cycle.
    fn is_interrupted(&self) -> bool;

    /// Returns whether anybody uses reports of this kind.
    fn wants_report(&self, kind: &str) -> bool;
}

/// A request that waits for its provider's cycle.
pub struct WaitingRequest {
    /// Identifies the request in the reply.
    pub id: RequestId,
    /// The request, in the caller's type.
    pub argument: Arc<dyn Sample>,
    /// Name of the calling component.
    pub caller: Arc<str>,
    /// Time at which the caller stops waiting; `None` for a one-way call.
    pub deadline: Option<Time>,
}
