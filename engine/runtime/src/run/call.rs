//! Calls of operations from outside a system: sent first, collected when they have ended.

use std::sync::{Arc, mpsc};

use asmotion_component::{CallError, Operation, SendStatus, unreadable};
use asmotion_datum::Sample;
use asmotion_port::Time;

use crate::handle::RunHandle;

/// A call from outside a system (RTT `SendHandle`).
pub struct SentCall<O: Operation> {
    pub(super) reply: mpsc::Receiver<Result<Arc<dyn Sample>, CallError>>,
    pub(super) deadline: Time,
    pub(super) handle: Arc<dyn RunHandle>,
    pub(super) of: std::marker::PhantomData<fn() -> O>,
}

impl<O: Operation> SentCall<O> {
    /// The current status of the call, with its result once it has ended.
    pub fn collect_if_done(&mut self) -> SendStatus<O::Response> {
        let late = self.handle.now() >= self.deadline;
        match self.reply.try_recv() {
            Ok(result) => read(result),
            Err(mpsc::TryRecvError::Empty | mpsc::TryRecvError::Disconnected) if late => {
                SendStatus::Failure(CallError::Timeout)
            }
            Err(mpsc::TryRecvError::Empty) => SendStatus::NotReady,
            // collected before, or dropped by a provider that will never reply
            Err(mpsc::TryRecvError::Disconnected) => SendStatus::Unknown,
        }
    }
}

fn read<R: asmotion_datum::Message>(result: Result<Arc<dyn Sample>, CallError>) -> SendStatus<R> {
    let read = result.and_then(|response| {
        response
            .read()
            .map_err(|error| CallError::Fault(unreadable("BAD_REPLY", &error)))
    });
    match read {
        Ok(response) => SendStatus::Success(response),
        Err(error) => SendStatus::Failure(error),
    }
}
