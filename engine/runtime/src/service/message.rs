//! Messages between callers and providers.

use std::sync::{Arc, OnceLock, mpsc};

use asmotion_bus::TraceContext;
use asmotion_component::CallError;
use asmotion_datum::Sample;
use asmotion_port::Time;
use crossbeam_queue::ArrayQueue;

use crate::effects::Effects;

/// Limit on the outstanding calls of one component; calls beyond it end as unavailable.
pub(super) const UNDER_WAY: usize = 128;

/// Identifies a call within the system.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct CallKey {
    /// The caller's position in the system; `usize::MAX` for callers outside, which do not cancel by key.
    pub caller: usize,
    /// The call's number at the caller.
    pub number: u64,
}

/// A message to a provider.
pub enum ProviderMessage {
    /// A call of an operation.
    Request(ServiceRequest),
    /// The caller has cancelled the call.
    Cancel(CallKey),
}

/// A request with its return address.
pub struct ServiceRequest {
    /// Identifies the call.
    pub key: CallKey,
    /// Position of the operation in the service.
    pub operation: usize,
    /// The request, in the caller's type.
    pub argument: Arc<dyn Sample>,
    /// Name of the calling component.
    pub caller: Arc<str>,
    /// Time at which the caller stops waiting; `None` for a one-way call.
    pub deadline: Option<Time>,
    /// The trace that the call continues; `None` without one.
    pub trace: Option<TraceContext>,
    /// Whether the call may wait for a provider that is not there yet; `false` if the reference has an alternative.
    pub awaits_provider: bool,
    /// Return address of the reply; `None` for a one-way call.
    pub reply_to: Option<ReplyTo>,
}

/// Return address of a reply.
pub enum ReplyTo {
    /// A component of this system.
    Component(ComponentReply),
    /// A caller that reached the service through an adapter, for example over a bus.
    Remote(Box<dyn RemoteCaller>),
    /// A thread outside the system that called [`Run::send`](crate::Run::send).
    External(mpsc::Sender<Result<Arc<dyn Sample>, CallError>>),
}

/// The return address of a component of this system.
pub struct ComponentReply(pub(super) Arc<ReplyQueue>);

/// A caller outside the system, reached through an adapter.
pub trait RemoteCaller: Send {
    /// Returns whether the caller still waits, as far as the adapter knows.
    fn is_awaited(&self) -> bool;

    /// Sends the result, which ends the call.
    fn reply(self: Box<Self>, result: Result<Arc<dyn Sample>, CallError>);
}

impl ReplyTo {
    /// Returns whether the caller still waits, as far as this process knows.
    pub(crate) fn is_awaited(&self) -> bool {
        match self {
            // a component cancels a call that it no longer waits for; an external caller has a deadline
            Self::Component(_) | Self::External(_) => true,
            Self::Remote(caller) => caller.is_awaited(),
        }
    }

    /// Sends the result of the caller's call with this number.
    pub fn send(
        self,
        number: u64,
        result: Result<Arc<dyn Sample>, CallError>,
        effects: &mut dyn Effects,
    ) {
        match self {
            Self::Component(reply) => reply.0.push(CallAnswer { number, result }, effects),
            // fails if the caller has stopped waiting
            Self::External(answer) => drop(answer.send(result)),
            Self::Remote(caller) => caller.reply(result),
        }
    }
}

/// A reply on its way to a caller.
pub(crate) struct CallAnswer {
    /// The call's number at the caller.
    pub number: u64,
    pub result: Result<Arc<dyn Sample>, CallError>,
}

/// Replies that wait for their caller. Providers on any thread push them; the caller's thread pops them.
pub(crate) struct ReplyQueue {
    /// Created by the caller, at the latest with its first call: a component without references has none.
    queue: OnceLock<Box<ArrayQueue<CallAnswer>>>,
    /// Position of the caller in the system.
    component: usize,
}

impl ReplyQueue {
    /// Creates the queue of the caller at this position of the system.
    pub(super) fn new(component: usize) -> Self {
        Self {
            queue: OnceLock::new(),
            component,
        }
    }

    /// The replies that wait.
    pub(super) fn queue(&self) -> &ArrayQueue<CallAnswer> {
        let make = || Box::new(ArrayQueue::new(UNDER_WAY));
        self.queue.get_or_init(make)
    }

    /// Pushes a reply. If the queue is full, the reply is dropped and the call ends at its deadline.
    pub(crate) fn push(&self, answer: CallAnswer, effects: &mut dyn Effects) {
        if self.queue().push(answer).is_ok() {
            effects.trigger(self.component);
        }
    }
}
