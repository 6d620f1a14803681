//! What travels between caller and provider.

use std::sync::{Arc, mpsc};

use asmotion_bus::TraceContext;
use asmotion_component::CallError;
use asmotion_datum::Sample;
use asmotion_port::Time;

use super::calls::ReplyQueue;
use crate::effects::Effects;

/// Names one call in the system.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct CallKey {
    /// The caller's position in the system; `usize::MAX` for callers outside, which do not cancel by key.
    pub caller: usize,
    /// The call's number at the caller.
    pub number: u64,
}

/// A message to a provider.
pub enum ProviderMessage {
    /// A request.
    Request(ServiceRequest),
    /// The caller no longer waits.
    Cancel(CallKey),
}

/// A request with its return address.
pub struct ServiceRequest {
    /// Names the call.
    pub key: CallKey,
    /// Position of the operation in the service.
    pub operation: usize,
    /// The argument, in the caller's type.
    pub argument: Arc<dyn Sample>,
    /// The caller's name.
    pub caller: Arc<str>,
    /// When the caller gives up; absent for a one-way call.
    pub deadline: Option<Time>,
    /// What the request follows from.
    pub trace: Option<TraceContext>,
    /// Where the answer goes; absent for a one-way call.
    pub reply_to: Option<ReplyTo>,
}

/// Where an answer goes.
pub enum ReplyTo {
    /// To a component of this system.
    Component(ComponentReply),
    /// To a caller that reached the service through an adapter: over a bus, say.
    Remote(Box<dyn RemoteCaller>),
    /// To a thread outside of the system that called by [`Run::send`](crate::Run::send).
    External(mpsc::Sender<Result<Arc<dyn Sample>, CallError>>),
}

/// The return address of a component of this system.
pub struct ComponentReply(pub(super) Arc<ReplyQueue>);

/// A caller beyond the system.
pub trait RemoteCaller: Send {
    /// Whether the caller still waits, as far as that is known here.
    fn is_awaited(&self) -> bool;

    /// Ends the call.
    fn reply(self: Box<Self>, result: Result<Arc<dyn Sample>, CallError>);
}

impl ReplyTo {
    /// Whether the caller still waits, as far as that is known here.
    pub(crate) fn is_awaited(&self) -> bool {
        match self {
            // A component cancels its call when it no longer waits; an external caller has a deadline.
            Self::Component(_) | Self::External(_) => true,
            Self::Remote(caller) => caller.is_awaited(),
        }
    }

    /// Answers the caller's call of this number.
    pub fn send(
        self,
        number: u64,
        result: Result<Arc<dyn Sample>, CallError>,
        effects: &mut dyn Effects,
    ) {
        match self {
            Self::Component(reply) => reply.0.put(CallAnswer { number, result }, effects),
            // A caller that has given up does not read it.
            Self::External(answer) => drop(answer.send(result)),
            Self::Remote(caller) => caller.reply(result),
        }
    }
}

/// A message to a caller.
pub(crate) struct CallAnswer {
    /// The call's number at the caller.
    pub number: u64,
    pub result: Result<Arc<dyn Sample>, CallError>,
}
