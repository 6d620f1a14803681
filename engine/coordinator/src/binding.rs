//! The binding between the functions of a specification and its environment, as plain data.
//!
//! Names and kinds are checked when the composite is read; remaining errors become a
//! [`BindError`](crate::bind_error::BindError) when the coordinator is built.

use std::fmt;

use asmotion_datum::{Datum, Schema};
use asmotion_derive::Word;
use serde::{Serialize, Serializer};

/// The messages that supply monitored functions, and the effects of updates of out functions.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Binding {
    /// Bindings of monitored functions.
    pub monitored: Vec<Monitored>,
    /// Bindings of out functions.
    pub out: Vec<Out>,
}

/// The ports, references and services of the component that runs a specification, with their types.
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

/// The binding of a monitored function.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Monitored {
    /// Name of the function.
    pub function: String,
    /// Origin of its value.
    #[serde(flatten)]
    pub from: Source,
    /// The messages that count as its value.
    pub receive: Receive,
    /// Path of the value in the message, for example `pose.position.x`. Without it, the message itself or its only
    /// field.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub field: Option<String>,
    /// Path of a text that names an enum literal; an alternative to `field`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub map: Option<String>,
    /// The texts for which a Boolean function is true. If empty, the value itself is used.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub is: Vec<String>,
    /// Value in a step without a message; undef if not given.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub none: Option<Constant>,
    /// Age in milliseconds after which the last message is stale; unlimited if not given.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub stale_ms: Option<u64>,
    /// Value if the last message is stale, or if there has been none.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub on_stale: Option<Constant>,
}

/// Origin of a monitored function's value.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Source {
    /// Messages on an input port, given by its name.
    Port(String),
    /// Requests for an operation that the component provides.
    Request {
        /// Name of the service.
        service: String,
        /// Name of the operation within the interface.
        operation: String,
    },
}

/// The messages that count as the value of a step.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Word)]
#[serde(rename_all = "snake_case")]
pub enum Receive {
    /// The newest message, however old (TCA's `receiveLast`).
    #[default]
    Last,
    /// One message per step, in order; the others wait for the following steps (TCA's `receiveAll`).
    All,
    /// None: the value is `true` in steps in which a message arrived, and `false` in all others.
    Edge,
}

/// The binding of an out function.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Out {
    /// Name of the function.
    pub function: String,
    /// Effect of its updates.
    pub effect: Effect,
}

/// The effect of updates of an out function.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Effect {
    /// Publishes the value itself.
    Publish {
        /// Name of the output port.
        port: String,
        /// The field that takes the value. Without it, the message itself.
        #[serde(skip_serializing_if = "Option::is_none")]
        field: Option<String>,
        /// The steps after which it is published.
        when: PublishWhen,
    },
    /// Runs actions that depend on the literal; literals that are not listed have no effect.
    Literals(Vec<Case>),
}

/// The steps after which the value of an out function is published.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Word)]
#[serde(rename_all = "snake_case")]
pub enum PublishWhen {
    /// Steps that updated the function, even to the same value.
    #[default]
    OnUpdate,
    /// Steps that changed the function's value.
    OnChange,
    /// All steps.
    EveryStep,
}

/// The actions of an update of an out function to one literal, in order.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Case {
    /// The enum literal.
    pub literal: String,
    /// The actions, in order.
    pub actions: Vec<Action>,
}

/// An action of an update.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Action {
    /// Calls an operation of a service.
    Call(Call),
    /// Publishes a message.
    Publish {
        /// Name of the output port.
        port: String,
        /// Content of the message.
        value: Argument,
    },
}

/// A call of a service, whose outcome comes back as an event.
///
/// A later update of the same out function cancels the call, because its outcome would no longer be relevant.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Call {
    /// Name of the component's reference.
    pub reference: String,
    /// Name of the operation within the interface.
    pub operation: String,
    /// The request.
    pub with: Argument,
    /// Name under which the response is kept for later arguments.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub keep: Option<String>,
    /// The monitored function that takes one of the following literals when the call ends.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub event: Option<String>,
    /// Literal for a response.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub ok: Option<String>,
    /// Literal for a fault.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub failed: Option<String>,
    /// Literal for a timeout; `failed` if not given.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub timeout: Option<String>,
    /// Literal for an unavailable provider; `failed` if not given.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub unavailable: Option<String>,
    /// The service whose request this call is made for: the caller gets the outcome as its reply.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub reply: Option<String>,
}

/// The content of a message or request.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Argument {
    /// The default of the type.
    Default,
    /// A response that was kept, the newest message of an input port, or the newest request of a service.
    Kept {
        /// Name of the kept response, port or service.
        name: String,
        /// Path within it, for example `pose.position`; all of it if not given.
        #[serde(skip_serializing_if = "Option::is_none")]
        path: Option<String>,
    },
    /// A record; omitted fields have their initial values.
    Record(Vec<(String, Argument)>),
    /// A literal value.
    Value(Constant),
}

/// A value given by the composite; displayed as `***` if it contains a secret.
#[derive(Clone, PartialEq)]
pub struct Constant {
    /// The value, with secrets in plain text.
    pub datum: Datum,
    /// `true` if a secret property was used in it.
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
        if self.secret {
            f.write_str("***")
        } else {
            fmt::Debug::fmt(&self.datum, f)
        }
    }
}

impl Serialize for Constant {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        if self.secret {
            serializer.serialize_str("***")
        } else {
            self.datum.serialize(serializer)
        }
    }
}

pub(crate) fn calls(binding: &Binding) -> impl Iterator<Item = &Call> {
    let cases = binding.out.iter().flat_map(|out| match &out.effect {
        Effect::Literals(cases) => cases.as_slice(),
        Effect::Publish { .. } => &[],
    });
    cases
        .flat_map(|case| &case.actions)
        .filter_map(|action| match action {
            Action::Call(call) => Some(call),
            Action::Publish { .. } => None,
        })
}
