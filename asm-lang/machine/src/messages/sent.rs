//! What a step sent, as whoever carries it sees it.

use asmotion_ir::Messages;
use asmotion_value::Value;

/// A message, by number.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct MessageId(pub u64);

/// A message that a step sent.
#[derive(Clone, Debug, PartialEq)]
pub struct SentMessage {
    /// Its number.
    pub id: MessageId,
    /// The agent that sent it; undef where the specification has no agents.
    pub from: Value,
    /// Whom it is for.
    pub to: Value,
    /// The operation, as the specification spells it.
    pub operation: Value,
    /// What it is.
    pub kind: SentKind,
    /// Whether it leaves the specification: see [`Machine::set_partners`](crate::Machine::set_partners).
    pub leaves: bool,
}

/// What a message is.
#[derive(Clone, Debug, PartialEq)]
pub enum SentKind {
    /// Something that may be answered.
    Message {
        /// What it says.
        data: Value,
    },
    /// A request whose reply is waited for.
    Call {
        /// What it says.
        data: Value,
        /// Until when.
        deadline_ns: Option<i64>,
    },
    /// A reply.
    Reply {
        /// What it says.
        data: Value,
        /// The message it answers, if that is known.
        to: Option<MessageId>,
    },
    /// A call that is not waited for any longer.
    Cancel {
        /// The call.
        call: MessageId,
    },
}

/// Why a call ended without a reply.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CallFault {
    /// It was not answered in time.
    Timeout,
    /// Nobody could take it.
    Unavailable,
    /// Its provider failed.
    Failed,
    /// It was taken back.
    Cancelled,
}

impl CallFault {
    const ALL: [Self; 4] = [
        Self::Timeout,
        Self::Unavailable,
        Self::Failed,
        Self::Cancelled,
    ];

    /// Its number in a packed state.
    pub(super) fn number(self) -> u64 {
        match self {
            Self::Timeout => 0,
            Self::Unavailable => 1,
            Self::Failed => 2,
            Self::Cancelled => 3,
        }
    }

    /// The fault of this number.
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
