//! The binding of an ASM component as written; [`asmotion_coordinator::Binding`] is the same without places.

use asmotion_derive::Table;
use asmotion_diagnostics::Span;

use asmotion_coordinator::{PublishWhen, Receive};

use super::{DAY_MS, End, MessagePath};
use crate::at::At;
use crate::tree::Node;

/// Functions of an ASM and the world.
#[derive(Clone, Debug, Default, Table)]
#[table(of = "`bind`", example = "{ monitored = { }, out = { } }")]
pub struct Bind {
    /// Where the values of monitored functions come from.
    #[key(example = "{ }")]
    pub monitored: Vec<Monitored>,
    /// What updates of out functions do.
    #[key(example = "{ }")]
    pub out: Vec<Out>,
}

/// The binding of a monitored function.
#[derive(Clone, Debug, Table)]
#[table(
    of = "a bound monitored function",
    example = "{ topic = \"estop\", field = \"data\" }",
    after = crate::read::binding::monitored
)]
pub struct Monitored {
    /// The function.
    #[key(entry = any)]
    pub function: At<String>,
    /// Where its value comes from.
    #[key(flatten)]
    pub from: Source,
    /// The messages that count as the value of a step.
    pub receive: Option<At<Receive>>,
    /// The same as `receive = "edge"`.
    pub edge: Option<At<bool>>,
    /// The part of the message that is the value; its only field, `data` or `code`, if absent.
    #[key(example = "\"data\"")]
    pub field: Option<MessagePath>,
    /// The field whose text names an enum literal.
    #[key(example = "\"data\"")]
    pub map: Option<MessagePath>,
    /// The texts for which it is true.
    #[key(example = "\"idle\"")]
    pub is: Vec<At<String>>,
    /// The value in a step without a message.
    pub none: Option<Node>,
    /// Age in milliseconds after which the last message is stale; unlimited if not given.
    #[key(unit = "milliseconds", range = 1..=DAY_MS)]
    pub stale_ms: Option<At<u64>>,
    /// Value if the last message is stale, or if there has been none.
    pub on_stale: Option<Node>,
}

impl Monitored {
    /// The messages that count as the value of a step.
    pub fn received(&self) -> At<Receive> {
        let last = || At::new(Receive::default(), self.function.span);
        self.receive.clone().unwrap_or_else(last)
    }
}

/// Where the value of a monitored function comes from.
#[derive(Clone, Debug, Table)]
#[table(
    of = "a bound monitored function",
    reason = "a value comes from one source"
)]
pub enum Source {
    /// A name under `subscribe` or `ports.in`.
    #[key(example = "\"estop\"")]
    Topic(At<String>),
    /// `service.operation`: requests that the component answers; the `component` of the end is the service.
    #[key(name = "service", example = "\"move.moveTo\"")]
    Request(End),
}

/// An out function and what its updates do.
#[derive(Clone, Debug)]
pub struct Out {
    /// The function.
    pub function: At<String>,
    /// What its updates do.
    pub effect: Effect,
}

/// What the updates of an out function do.
#[derive(Clone, Debug)]
pub enum Effect {
    /// The value itself is published.
    Publish(Published),
    /// Each literal has its actions.
    Literals(Vec<(At<String>, Vec<Action>)>),
}

/// The value of an out function is published.
#[derive(Clone, Debug, Table)]
#[table(
    of = "a bound out function",
    example = "{ topic = \"command\", publish = \"on_update\" }"
)]
pub struct Published {
    /// The name under `publish` or `ports.out`.
    #[key(example = "\"command\"")]
    pub topic: At<String>,
    /// The field that takes the value.
    #[key(example = "\"data\"")]
    pub field: Option<MessagePath>,
    /// The steps after which it is published.
    #[key(name = "publish")]
    pub when: Option<At<PublishWhen>>,
}

/// What an update to a literal does.
#[derive(Clone, Debug, Table)]
#[table(
    of = "an action",
    example = "{ call = \"planner.plan\", ok = \"PATH_OK\", event = \"ev\" }",
    reason = "an action has one effect; use a list for several"
)]
pub enum Action {
    /// Calls a service.
    #[key(flatten)]
    Call(Box<Call>),
    /// Publishes a message.
    Publish {
        /// Publishes a message: the name under `publish` or `ports.out`.
        #[key(name = "publish", example = "\"plan\"")]
        topic: At<String>,
        /// Content of the message.
        #[key(example = "\"@path\"")]
        value: Argument,
    },
}

/// A call of a service.
#[derive(Clone, Debug, Table)]
#[table(of = "an action", after = crate::read::binding::call)]
pub struct Call {
    /// Calls a service: `reference.operation`; the `component` of the end is the reference.
    #[key(name = "call", example = "\"planner.plan\"")]
    pub operation: End,
    /// The request.
    pub with: Option<Argument>,
    /// Name under which the reply is kept.
    #[key(example = "\"path\"")]
    pub keep: Option<At<String>>,
    /// Literal of `event` for a reply.
    #[key(example = "\"PATH_OK\"")]
    pub ok: Option<At<String>>,
    /// Literal for a fault.
    #[key(example = "\"CALL_FAILED\"")]
    pub failed: Option<At<String>>,
    /// Literal for a reply that did not come in time; `failed`, if absent.
    #[key(example = "\"CALL_FAILED\"")]
    pub timeout: Option<At<String>>,
    /// Literal for no provider; `failed`, if absent.
    #[key(example = "\"NOBODY_THERE\"")]
    pub unavailable: Option<At<String>>,
    /// Monitored function that takes these literals.
    #[key(example = "\"ev\"")]
    pub event: Option<At<String>>,
    /// Service whose caller is answered as this call is.
    #[key(example = "\"move\"")]
    pub reply: Option<At<String>>,
}

/// A message or an argument, put together.
#[derive(Clone, Debug)]
pub enum Argument {
    /// `"@name"` or `"@name.field"`: a kept reply, or the last message of a topic.
    Kept {
        /// The name of the reply or topic.
        name: At<String>,
        /// The part of it.
        path: Vec<At<String>>,
    },
    /// A record, field by field; fields left out have their default.
    Record(Span, Vec<(At<String>, Argument)>),
    /// Anything else; texts may hold substitutions.
    Value(Node),
}
