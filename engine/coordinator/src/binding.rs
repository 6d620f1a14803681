//! The binding between the functions of a specification and the world, as plain data.
//!
//! Names and kinds were checked when the composite was read; what does not fit all the same is a
//! [`BindError`](crate::coordinator::BindError) when the coordinator is built.

use std::fmt;

use asmotion_datum::{Datum, Schema};
use asmotion_derive::Word;
use serde::{Serialize, Serializer};

/// Which messages become the values of monitored functions, and what updates of out functions do.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Binding {
    /// Monitored functions.
    pub monitored: Vec<Monitored>,
    /// Out functions.
    pub out: Vec<Out>,
}

/// The ports and references of the component that runs a specification, with their types.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Interfaces {
    /// Input ports and their message types.
    pub inputs: Vec<(String, Schema)>,
    /// Output ports and their message types.
    pub outputs: Vec<(String, Schema)>,
    /// References and the names of their interfaces.
    pub references: Vec<(String, String)>,
    /// Services and the names of their interfaces.
    pub services: Vec<(String, String)>,
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
    /// The part of the message that is the value, as in `pose.position.x`; the message itself, or its
    /// only field, where not given.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub field: Option<String>,
    /// The field whose text names an enum literal; read like `field`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub map: Option<String>,
    /// The texts for which it is true; the value is taken as it is where there are none.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub is: Vec<String>,
    /// The value in a step without a message; undef where not given.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub none: Option<Constant>,
    /// How old the last message may be.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub stale_ms: Option<u64>,
    /// The value when it is older, or when none came yet.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub on_stale: Option<Constant>,
}

/// Where the value of a monitored function comes from.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Source {
    /// An input port.
    Port(String),
    /// Requests of an operation that the component serves.
    Request {
        /// The service.
        service: String,
        /// The operation of its interface.
        operation: String,
    },
}

/// Which of the messages that came is the value in a step.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Word)]
#[serde(rename_all = "snake_case")]
pub enum Receive {
    /// The last one that ever came (TCA's `receiveLast`).
    #[default]
    Last,
    /// One a step; the others wait for the following steps (TCA's `receiveAll`).
    All,
    /// None: the value is true in the step in which a message came, and false in the others.
    Edge,
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
        /// The output port.
        port: String,
        /// The field that takes the value; the message itself where not given.
        #[serde(skip_serializing_if = "Option::is_none")]
        field: Option<String>,
        /// After which steps.
        when: PublishWhen,
    },
    /// Each literal has its actions; other literals do nothing.
    Literals(Vec<Case>),
}

/// After which steps the value of an out function is published.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Word)]
#[serde(rename_all = "snake_case")]
pub enum PublishWhen {
    /// After those that updated it, also to the value it had.
    #[default]
    OnUpdate,
    /// After those that changed it.
    OnChange,
    /// After all.
    EveryStep,
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
        /// The output port.
        port: String,
        /// The message.
        value: Argument,
    },
}

/// A call of a service; its outcome comes back as an event. An update of the same out function takes
/// back the calls that an earlier one made: their outcome would answer a question no longer asked.
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
    /// A reply that was kept, the last message of the input port of this name, or what this service was asked last.
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
    Value(Constant),
}

/// A value that the composite gives; shown as `***` where a secret is in it.
#[derive(Clone, PartialEq)]
pub struct Constant {
    /// The value.
    pub datum: Datum,
    /// Whether a secret is in it.
    pub secret: bool,
}

impl From<Datum> for Constant {
    fn from(datum: Datum) -> Self {
        let secret = false;
        Self { datum, secret }
    }
}

impl fmt::Debug for Constant {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.secret {
            true => f.write_str("***"),
            false => fmt::Debug::fmt(&self.datum, f),
        }
    }
}

impl Serialize for Constant {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match self.secret {
            true => serializer.serialize_str("***"),
            false => self.datum.serialize(serializer),
        }
    }
}
