//! Operations: requests that are called in one cycle and answered in a later one. No cycle waits.

use std::sync::Arc;

use asmotion_datum::{Datum, DatumError, Message, Sample};
use asmotion_port::Time;
use serde::{Deserialize, Serialize};

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
pub fn unreadable(code: &str, error: &DatumError) -> ServiceFault {
    ServiceFault::new(code, error.to_string())
}

/// Serves an operation in its caller's thread (RTT `ClientThread`).
pub type Handler =
    Arc<dyn Fn(Arc<dyn Sample>) -> Result<Arc<dyn Sample>, ServiceFault> + Send + Sync>;

/// What a handle of an operation stands for: an operation of a service or of a reference.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct OperationSlot {
    /// Position of the service or reference in its component.
    pub port: usize,
    /// Position of the operation in the service or reference.
    pub operation: usize,
}
