//! Services at run time: a queue of requests at the provider, outstanding calls and their replies at the caller.

mod calls;
mod message;
mod provider;
mod reference;

pub(crate) use calls::OutgoingCalls;
pub use message::{
    CallKey, ComponentReply, ProviderMessage, RemoteCaller, ReplyTo, ServiceRequest,
};
pub(crate) use provider::ProvidedService;
pub use provider::RequestQueue;
pub(crate) use reference::{RequiredReference, Wiring};
