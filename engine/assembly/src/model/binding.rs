//! The binding of an ASM component as written; [`asmotion_coordinator::Binding`] is the same without places.

use asmotion_diagnostics::Span;

use asmotion_coordinator::{PublishWhen, Receive};

use super::{End, Path};
use crate::At;
use crate::tree::Node;

/// `bind`: functions of an ASM and the world.
#[derive(Clone, Debug, Default)]
pub struct Bind {
    /// `bind.monitored`.
    pub monitored: Vec<Monitored>,
    /// `bind.out`.
    pub out: Vec<Out>,
}

/// A monitored function and where its value comes from.
#[derive(Clone, Debug)]
pub struct Monitored {
    /// The function.
    pub function: At<String>,
    /// Where its value comes from.
    pub from: Source,
    /// Which of the messages that came.
    pub receive: At<Receive>,
    /// The part of the message that is the value.
    pub field: Option<Path>,
    /// The field whose text names an enum literal.
    pub map: Option<Path>,
    /// The texts for which it is true.
    pub is: Vec<At<String>>,
    /// The value in a step without a message.
    pub none: Option<Node>,
    /// How old the last message may be.
    pub stale_ms: Option<At<i64>>,
    /// The value when it is older, or when none came yet.
    pub on_stale: Option<Node>,
}

/// Where the value of a monitored function comes from.
#[derive(Clone, Debug)]
pub enum Source {
    /// A name under `subscribe` or `ports.in`.
    Topic(At<String>),
    /// `service.operation`: requests; the `component` of the end is the service.
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
    Publish {
        /// The name under `publish` or `ports.out`.
        topic: At<String>,
        /// The field that takes the value.
        field: Option<Path>,
        /// After which steps.
        when: Option<At<PublishWhen>>,
    },
    /// Each literal has its actions.
    Literals(Vec<(At<String>, Vec<Action>)>),
}

/// What an update to a literal does.
#[derive(Clone, Debug)]
pub enum Action {
    /// Calls a service.
    Call(Box<Call>),
    /// Publishes a message.
    Publish {
        /// The name under `publish` or `ports.out`.
        topic: At<String>,
        /// The message.
        value: Argument,
    },
}

/// `{ call = "maps.getMap", … }`.
#[derive(Clone, Debug)]
pub struct Call {
    /// `reference.operation`; the `component` of the end is the reference.
    pub operation: End,
    /// The argument.
    pub with: Option<Argument>,
    /// The name under which the reply is kept.
    pub keep: Option<At<String>>,
    /// The literal that tells the ASM of the reply.
    pub ok: Option<At<String>>,
    /// The literal that tells it of a fault.
    pub failed: Option<At<String>>,
    /// The literal that tells it of a reply that did not come.
    pub timeout: Option<At<String>>,
    /// The literal that tells it that nobody is there to answer.
    pub unavailable: Option<At<String>>,
    /// The monitored function that takes these literals.
    pub event: Option<At<String>>,
    /// The service whose caller hears how the call has ended.
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
