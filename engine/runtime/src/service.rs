//! Services at run time: a queue of requests at the provider, outstanding calls and their replies at the caller.

mod calls;
mod message;
mod provider;
mod reference;

pub(crate) use calls::{FrozenCalls, OutgoingCalls};
pub use message::{
    CallKey, ComponentReply, ProviderMessage, RemoteCaller, ReplyTo, ServiceRequest,
};
pub use provider::RequestQueue;
pub(crate) use provider::{Admission, FrozenService, ProvidedService, ThawContext, UnheardRefusal};
pub(crate) use reference::{RequiredReference, Wiring};
