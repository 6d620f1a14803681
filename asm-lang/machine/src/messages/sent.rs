//! Messages sent by a step, for the transport to deliver.

use asmotion_ir::Messages;
use asmotion_value::Value;

/// Number of a message, unique within a machine and increasing.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct MessageId(pub u64);

/// A message sent by a step.
#[derive(Clone, Debug, PartialEq)]
pub struct SentMessage {
    /// Id of the message; a reply refers to its request's.
    pub id: MessageId,
    /// The sending agent; undef in a specification without agents.
    pub from: Value,
    /// The receiving agent, in this specification or outside.
    pub to: Value,
    /// The operation as written in the specification, for example `r_plan(Agent,Goal)`.
    pub operation: Value,
    /// Kind of the message, with its data.
    pub kind: SentKind,
    /// `true` if the receiver is outside this specification: see
    /// [`Machine::set_partners`](crate::Machine::set_partners).
    pub leaves: bool,
}

/// The kind of a message.
#[derive(Clone, Debug, PartialEq)]
pub enum SentKind {
    /// A one-way message, or a request whose sender does not wait for the reply.
    Message {
        /// The data, in the domain of the operation.
        data: Value,
    },
    /// A request whose sender waits for the reply.
    Call {
        /// The data, in the domain of the operation.
        data: Value,
        /// Time at which the call fails, in nanoseconds; `None` for no limit.
        deadline_ns: Option<i64>,
    },
    /// A reply to a request.
    Reply {
        /// The data, in the codomain of the operation.
        data: Value,
        /// Id of the request; `None` if the agent had received none from this partner.
        to: Option<MessageId>,
    },
    /// The withdrawal of a call.
    Cancel {
        /// Id of the call.
        call: MessageId,
    },
}

impl SentMessage {
    /// Returns the same message with other values; `None` if a value has no translation.
    pub(super) fn translated(&self, translate: &dyn Fn(&Value) -> Option<Value>) -> Option<Self> {
        let kind = match &self.kind {
            SentKind::Message { data } => SentKind::Message {
                data: translate(data)?,
            },
            SentKind::Call { data, deadline_ns } => SentKind::Call {
                data: translate(data)?,
                deadline_ns: *deadline_ns,
            },
            SentKind::Reply { data, to } => SentKind::Reply {
                data: translate(data)?,
                to: *to,
            },
            SentKind::Cancel { call } => SentKind::Cancel { call: *call },
        };
        Some(Self {
            from: translate(&self.from)?,
            to: translate(&self.to)?,
            kind,
            ..self.clone()
        })
    }
}

/// The reason that a call ended without a reply.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CallFault {
    /// The deadline passed.
    Timeout,
    /// No provider accepted the call.
    Unavailable,
    /// The provider reported a failure.
    Failed,
    /// The caller withdrew the call.
    Cancelled,
}

impl CallFault {
    const ALL: [Self; 4] = [
        Self::Timeout,
        Self::Unavailable,
        Self::Failed,
        Self::Cancelled,
    ];

    /// Returns the number that stands for the fault in a packed state.
    pub(super) fn number(self) -> u64 {
        match self {
            Self::Timeout => 0,
            Self::Unavailable => 1,
            Self::Failed => 2,
            Self::Cancelled => 3,
        }
    }

    /// Returns the fault with this number.
    pub(super) fn of(number: u64) -> Option<Self> {
        Self::ALL.into_iter().find(|fault| fault.number() == number)
    }

    pub(crate) fn value(self, messages: &Messages) -> Value {
        match self {
            Self::Timeout => messages.timeout.clone(),
            Self::Unavailable => messages.no_provider.clone(),
            Self::Failed => messages.failed.clone(),
            Self::Cancelled => messages.cancelled.clone(),
        }
    }
}
