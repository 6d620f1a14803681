//! Messages that reached a machine from outside between two steps of a recorded run.

use crate::literal::Literals;
use asmotion_ir::ValueShape;
use asmotion_machine::{CallFault, Machine, MessageId};
use asmotion_value::Value;
use serde::{Deserialize, Serialize};

/// An act of the outside on the messages of a machine. Values are texts, so that a recording can be replayed with an edited
/// specification, whose elements have other numbers.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(tag = "kind", rename_all = "snake_case")]
pub enum RecordedMessage {
    /// A message arrived for an agent.
    Delivered {
        /// Sending agent; undef for a caller of the component.
        from: String,
        /// Receiving agent.
        to: String,
        /// Name of the operation.
        operation: String,
        /// Content of the message.
        data: String,
    },
    /// A call ended with a reply.
    Replied {
        /// Number of the message that made the call.
        call: u64,
        /// Name of the operation.
        operation: String,
        /// Content of the reply.
        data: String,
    },
    /// A call ended without a reply.
    Failed {
        /// Number of the message that made the call.
        call: u64,
        /// The fault, as in scripts: `CALL_TIMEOUT`, `CALL_UNAVAILABLE`, `CALL_FAILED` or `CALL_CANCELLED`.
        fault: String,
    },
    /// A message could not be sent.
    Unsent {
        /// Sending agent.
        from: String,
        /// Name of the operation.
        operation: String,
    },
    /// The channel to the outside went down, or came back.
    Channel {
        /// `true` while it delivers no messages.
        is_down: bool,
    },
}

/// A recorded message that does not fit the specification: its operation or a value in it.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("the specification does not know `{0}`")]
pub struct UnfitMessage(pub String);

impl RecordedMessage {
    /// Repeats the act on a machine.
    ///
    /// # Errors
    /// The text that denotes no value of the machine's program; the machine is unchanged.
    pub fn apply(&self, machine: &mut Machine) -> Result<(), UnfitMessage> {
        match self {
            Self::Delivered {
                from,
                to,
                operation,
                data,
            } => {
                let (from, to) = (agent(from, machine)?, agent(to, machine)?);
                let data = content(operation, data, machine)?;
                machine.deliver(from, to, operation, data);
            }
            Self::Replied {
                call,
                operation,
                data,
            } => {
                let data = content(operation, data, machine)?;
                machine.end_call(MessageId(*call), Ok(data));
            }
            Self::Failed { call, fault } => {
                let known = fault_named(fault).ok_or_else(|| UnfitMessage(fault.clone()))?;
                machine.end_call(MessageId(*call), Err(known));
            }
            Self::Unsent { from, operation } => {
                let from = agent(from, machine)?;
                machine.set_unsent(from, operation);
            }
            Self::Channel { is_down } => machine.set_channel_down(*is_down),
        }
        Ok(())
    }
}

/// Names of the faults of calls, as scripts and recordings spell them.
const FAULTS: [(&str, CallFault); 4] = [
    ("CALL_TIMEOUT", CallFault::Timeout),
    ("CALL_UNAVAILABLE", CallFault::Unavailable),
    ("CALL_FAILED", CallFault::Failed),
    ("CALL_CANCELLED", CallFault::Cancelled),
];

/// Returns the fault of a call with this name.
pub(crate) fn fault_named(name: &str) -> Option<CallFault> {
    let found = FAULTS.iter().find(|(known, _)| *known == name);
    found.map(|(_, fault)| *fault)
}

/// Returns the name of the fault of a call, as in scripts.
pub fn fault_name(fault: CallFault) -> &'static str {
    let found = FAULTS.iter().find(|(_, known)| *known == fault);
    found.map_or("", |(name, _)| name)
}

/// Parses an agent of a recording, such as those given to [`Machine::set_partners`].
///
/// # Errors
/// The text denotes no element of the machine's program.
pub fn agent(text: &str, machine: &Machine) -> Result<Value, UnfitMessage> {
    value(text, [&ValueShape::Any], machine)
}

/// Parses the content of a message of an operation, which is a request or a reply.
fn content(operation: &str, text: &str, machine: &Machine) -> Result<Value, UnfitMessage> {
    let known = machine.program().operation(operation);
    let shapes = [&known.takes, &known.gives, &ValueShape::Any];
    value(text, shapes, machine)
}

/// Parses a value of the first shape in which it is written like this: `3` is an integer, and no real number.
fn value<'s>(
    text: &str,
    shapes: impl IntoIterator<Item = &'s ValueShape>,
    machine: &Machine,
) -> Result<Value, UnfitMessage> {
    let naming = machine.naming();
    let literals = Literals::new(naming.program, naming.reserve);
    let shapes = shapes.into_iter();
    let mut values = shapes.filter_map(|shape| literals.value(text, shape));
    let found = values.find(|value| value.show(&naming).to_string() == text);
    found.ok_or_else(|| UnfitMessage(text.to_owned()))
}
