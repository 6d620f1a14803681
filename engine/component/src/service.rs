//! Services: operations with a deadline, called in one cycle, answered in a later one. No cycle waits.

mod caller;
mod post;
mod provider;
mod reference;

use asmotion_bus::CallFailure;
use asmotion_datum::{Datum, DatumError, Message};
use serde::{Deserialize, Serialize};
use std::sync::Arc;
use std::time::Duration;

pub(crate) use caller::{Caller, Mailbox};
pub(crate) use post::{Answer, AnswerTo, Ask, CallKey, Post};
pub(crate) use provider::{Handler, Inbox, Service};
pub(crate) use reference::{Reference, Slot, Wiring};

use crate::Time;

/// An operation: a named request and response of an interface.
pub trait Operation: 'static {
    /// What the caller sends.
    type Request: Message;
    /// What the provider answers.
    type Response: Message;
    /// The interface the operation belongs to: `nav/PlanService`.
    const INTERFACE: &'static str;
    /// Its name in the interface: `plan`.
    const NAME: &'static str;
}

/// An operation known at run time only: data in, data out.
#[derive(Debug, Clone, Copy)]
pub struct Dynamic;

impl Operation for Dynamic {
    type Request = Datum;
    type Response = Datum;
    const INTERFACE: &'static str = "";
    const NAME: &'static str = "";
}

/// A call of one component, from its first attempt to its end.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
pub struct CallId(pub u64);

/// A request at one provider.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
pub struct RequestId(pub u64);

/// A request, as the provider sees it.
#[derive(Debug, Clone, PartialEq)]
pub struct Request<T> {
    /// To be named in the reply.
    pub id: RequestId,
    /// What is asked.
    pub argument: T,
    /// The caller's name.
    pub caller: Arc<str>,
    /// When the caller gives up; absent for a one-way call.
    pub deadline: Option<Time>,
}

/// The end of a call, as the caller sees it.
#[derive(Debug, Clone, PartialEq)]
pub struct Reply<T> {
    /// The call.
    pub call: CallId,
    /// How it ended.
    pub result: Result<T, CallError>,
}

/// Why a provider could not do what was asked.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error, Serialize, Deserialize)]
#[error("{code}: {detail}")]
pub struct ServiceFault {
    /// One of the operation's fault codes: `NO_PATH`.
    pub code: String,
    /// For people.
    pub detail: String,
}

impl ServiceFault {
    /// A fault of a code, explained.
    pub fn new(code: impl Into<String>, detail: impl Into<String>) -> Self {
        Self {
            code: code.into(),
            detail: detail.into(),
        }
    }
}

/// Why a call has no response.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum CallError {
    /// The deadline passed.
    #[error("no answer before the deadline")]
    Timeout,
    /// Nobody is there to answer: not wired, not running, or overwhelmed.
    #[error("nobody is there to answer")]
    Unavailable,
    /// The provider refused.
    #[error(transparent)]
    Fault(#[from] ServiceFault),
    /// The caller took it back.
    #[error("cancelled by the caller")]
    Cancelled,
}

impl From<CallFailure> for CallError {
    fn from(failure: CallFailure) -> Self {
        match failure {
            CallFailure::Timeout => Self::Timeout,
            CallFailure::Unavailable => Self::Unavailable,
            CallFailure::Refused(refusal) => {
                Self::Fault(ServiceFault::new(refusal.code, refusal.detail))
            }
            CallFailure::Cancelled => Self::Cancelled,
        }
    }
}

/// What has become of a call that was sent (RTT `SendStatus`).
#[derive(Debug, Clone, PartialEq)]
pub enum SendStatus<T> {
    /// It is under way.
    NotReady,
    /// It is done.
    Success(T),
    /// It has no response.
    Failure(CallError),
    /// No such call is under way: what became of it has been collected.
    Unknown,
}

/// The fault of an argument or response that is of another type.
pub(crate) fn unreadable(code: &str, error: &DatumError) -> ServiceFault {
    ServiceFault::new(code, error.to_string())
}

/// How a reference is joined to a service.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct Wire {
    /// How long one attempt may take.
    pub timeout: Duration,
    /// How often an attempt that got no answer is made again.
    pub retries: u32,
    /// The rest before it is made again the first time; each further one is twice as long.
    pub backoff: Duration,
    /// Whether the provider is told that an attempt timed out.
    pub cancel_on_timeout: bool,
    /// Whether calls have no reply at all (SCA `@OneWay`).
    pub one_way: bool,
}

impl Default for Wire {
    /// One attempt of one second; the provider is told when it times out.
    fn default() -> Self {
        Self {
            timeout: Duration::from_secs(1),
            retries: 0,
            backoff: Duration::ZERO,
            cancel_on_timeout: true,
            one_way: false,
        }
    }
}

impl Wire {
    /// One attempt of this length; the provider is told when it times out.
    pub fn timeout(timeout: Duration) -> Self {
        Self {
            timeout,
            ..Self::default()
        }
    }

    /// Without a reply.
    pub fn one_way() -> Self {
        Self {
            one_way: true,
            ..Self::default()
        }
    }

    /// With so many more attempts.
    #[must_use]
    pub fn retries(self, retries: u32) -> Self {
        Self { retries, ..self }
    }

    /// The rest after so many attempts.
    fn rest_after(&self, attempts: u32) -> Duration {
        let doublings = attempts.saturating_sub(1);
        self.backoff.saturating_mul(2_u32.saturating_pow(doublings))
    }
}
