//! The binding between the functions of an ASM and the world, as plain data.
//!
//! This is what the coordinator executes. It holds no places and no substitutions, and every name
//! in it was checked, so it can move to any room below.

use serde::Serialize;

use crate::Value;
use crate::choice::choice;

/// Which messages become the values of monitored functions, and what updates of out functions do.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Binding {
    /// Monitored functions, in the order of the file.
    pub monitored: Vec<Monitored>,
    /// Out functions, in the order of the file.
    pub out: Vec<Out>,
}

/// A monitored function and where its value comes from.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Monitored {
    /// The function.
    pub function: String,
    /// Where its value comes from.
    #[serde(flatten)]
    pub from: Source,
    /// Which of the messages that came.
    pub receive: Receive,
    /// The part of the message that is the value, as in `pose.position.x`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub field: Option<String>,
    /// The field whose text names an enum literal.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub map: Option<String>,
    /// The texts for which it is true.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub is: Vec<String>,
    /// The value in a step without a message; `undef` where not given.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub none: Option<Value>,
    /// How old the last message may be.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub stale_ms: Option<u64>,
    /// The value when it is older, or when none came yet.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub on_stale: Option<Value>,
}

/// Where the value of a monitored function comes from.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Source {
    /// An input port, which may be on a topic.
    Port(String),
    /// Requests of an operation that the component serves.
    Request {
        /// The service.
        service: String,
        /// The operation of its interface.
        operation: String,
    },
}

choice! {
    /// Which of the messages that came is the value in a step.
    pub enum Receive {
        /// The last one that ever came (TCA's receiveLast).
        Last = "last",
        /// One a step; the others wait for the following steps (TCA's receiveAll).
        All = "all",
        /// None: the value is true in the step in which a message came, and false in the others.
        Edge = "edge",
    }
}

/// An out function and what its updates do.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Out {
    /// The function.
    pub function: String,
    /// What its updates do.
    pub effect: Effect,
}

/// What the updates of an out function do.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Effect {
    /// The value itself is published.
    Publish {
        /// The output port, which may be on a topic.
        port: String,
        /// The field that takes the value; the message itself, or its only field, where not given.
        #[serde(skip_serializing_if = "Option::is_none")]
        field: Option<String>,
        /// After which steps.
        when: PublishWhen,
    },
    /// Each literal has its actions; other literals do nothing.
    Literals(Vec<Case>),
}

choice! {
    /// After which steps the value of an out function is published.
    pub enum PublishWhen {
        /// After those that updated it, also to the value it had.
        OnUpdate = "on_update",
        /// After those that changed it.
        OnChange = "on_change",
        /// After all.
        EveryStep = "every_step",
    }
}

/// A literal of an out function and what an update to it does, in this order.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Case {
    /// The literal.
    pub literal: String,
    /// What an update to it does.
    pub actions: Vec<Action>,
}

/// Something an update does.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Action {
    /// Calls a service.
    Call(Call),
    /// Publishes a message.
    Publish {
        /// The output port, which may be on a topic.
        port: String,
        /// The message.
        value: Argument,
    },
}

/// A call of a service; its outcome comes back as an event.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Call {
    /// The reference of the component.
    pub reference: String,
    /// The operation of its interface.
    pub operation: String,
    /// The argument.
    pub with: Argument,
    /// The name under which the reply is kept.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub keep: Option<String>,
    /// The monitored function that takes one of the following literals when the call has ended.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub event: Option<String>,
    /// The literal for a reply.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub ok: Option<String>,
    /// The literal for a fault.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub failed: Option<String>,
    /// The literal for a reply that did not come in time; `failed` where not given.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub timeout: Option<String>,
    /// The literal for nobody there to answer; `failed` where not given.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub unavailable: Option<String>,
    /// The service whose caller hears how the call has ended.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub reply: Option<String>,
}

/// A message or an argument, put together.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Argument {
    /// The default of the type.
    Default,
    /// A reply that was kept, or the last message of the input port of this name.
    Kept {
        /// The name of the reply or port.
        name: String,
        /// The part of it, as in `pose.position`; all of it where not given.
        #[serde(skip_serializing_if = "Option::is_none")]
        path: Option<String>,
    },
    /// A record; fields left out have their default.
    Record(Vec<(String, Argument)>),
    /// A value as written.
    Value(Value),
}
