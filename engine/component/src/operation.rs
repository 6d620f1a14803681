//! Operations: requests that are called in one cycle and answered in a later one, so that no cycle waits.

use std::sync::Arc;

use asmotion_datum::{Datum, DatumError, Message, Sample};
use asmotion_port::Time;
use serde::{Deserialize, Serialize};

/// An operation of an interface: a name, a request type and a response type.
pub trait Operation: 'static {
    /// Type of the request.
    type Request: Message;
    /// Type of the response.
    type Response: Message;
    /// Name of the operation's interface, for example `nav/PlanService`.
    const INTERFACE: &'static str;
    /// Name within the interface, for example `plan`.
    const NAME: &'static str;
}

/// An operation whose types are known only at run time; it passes [`Datum`] values.
#[derive(Debug, Clone, Copy)]
pub struct Dynamic;

impl Operation for Dynamic {
    type Request = Datum;
    type Response = Datum;
    const INTERFACE: &'static str = "";
    const NAME: &'static str = "";
}

/// Identifies a call of one component, from its first attempt to its end.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
pub struct CallId(pub u64);

/// Identifies a request at one provider.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
pub struct RequestId(pub u64);

/// A request, as the provider sees it.
#[derive(Debug, Clone, PartialEq)]
pub struct Request<T> {
    /// Identifies the request in the reply.
    pub id: RequestId,
    /// The request's data.
    pub argument: T,
    /// Name of the calling component.
    pub caller: Arc<str>,
    /// Time at which the caller stops waiting; `None` for a one-way call.
    pub deadline: Option<Time>,
}

/// The end of a call, as the caller sees it.
#[derive(Debug, Clone, PartialEq)]
pub struct Reply<T> {
    /// The call that has ended.
    pub call: CallId,
    /// The response or the error.
    pub result: Result<T, CallError>,
}

/// The reason that a provider could not carry out a request.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error, Serialize, Deserialize)]
#[error("{code}: {detail}")]
pub struct ServiceFault {
    /// One of the operation's fault codes, for example `NO_PATH`.
    pub code: String,
    /// Explanation for a human reader.
    pub detail: String,
}

impl ServiceFault {
    /// A fault with this code and explanation.
    pub fn new(code: impl Into<String>, detail: impl Into<String>) -> Self {
        Self {
            code: code.into(),
            detail: detail.into(),
        }
    }
}

/// The reason that a call has no response.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum CallError {
    /// The deadline passed without a reply.
    #[error("no answer before the deadline")]
    Timeout,
    /// The reference is not wired, no process provides the operation, or the provider's queue is full.
    #[error("no server is available")]
    Unavailable,
    /// The component that provides the operation does not run, and does not answer it while stopped.
    #[error("the component that provides it does not run")]
    Stopped,
    /// The provider replied with a fault.
    #[error(transparent)]
    Fault(#[from] ServiceFault),
    /// The caller cancelled the call.
    #[error("cancelled by the caller")]
    Cancelled,
}

/// Code of a fault by which a bridge to another system says that no server there has taken the request.
pub const NO_SERVER: &str = "NO_SERVER";

impl CallError {
    /// Returns whether no provider has taken the request, so that a later attempt, or another provider, may succeed.
    pub fn is_without_provider(&self) -> bool {
        match self {
            Self::Unavailable | Self::Stopped => true,
            Self::Fault(fault) => fault.code == NO_SERVER,
            Self::Timeout | Self::Cancelled => false,
        }
    }
}

/// Status of a call (RTT `SendStatus`).
#[derive(Debug, Clone, PartialEq)]
pub enum SendStatus<T> {
    /// The call is under way.
    NotReady,
    /// The provider has replied.
    Success(T),
    /// The call has ended without a response.
    Failure(CallError),
    /// No such call is under way; its result may have been collected already.
    Unknown,
}

/// The fault of a request or response that cannot be converted to the expected type.
pub fn unreadable(code: &str, error: &DatumError) -> ServiceFault {
    ServiceFault::new(code, error.to_string())
}

/// Converts a request or response to the expected type, and checks its values.
///
/// # Errors
/// The data do not fit the type, or fail [`Message::check`].
pub(crate) fn read_checked<T: Message>(sample: Arc<dyn Sample>) -> Result<T, DatumError> {
    let message: T = sample.read()?;
    message.check()?;
    Ok(message)
}

/// Handles an operation in the caller's thread (RTT `ClientThread`).
pub type Handler =
    Arc<dyn Fn(Arc<dyn Sample>) -> Result<Arc<dyn Sample>, ServiceFault> + Send + Sync>;

/// Position of an operation: in a service or a reference of the component.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct OperationSlot {
    /// Position of the service or reference in its component.
    pub port: usize,
    /// Position of the operation in the service or reference.
    pub operation: usize,
}
