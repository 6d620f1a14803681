//! The binding between the functions of a specification and its environment, as plain data.
//!
//! Names and kinds are checked when the composite is read; remaining errors become a
//! [`BindError`](crate::bind_error::BindError) when the coordinator is built.

use std::collections::BTreeSet;
use std::fmt;

use crate::location::LocationName;
use asmotion_datum::{Datum, Schema};
use asmotion_derive::Word;

/// The messages that supply monitored functions, and the effects of updates of out functions.
#[derive(Clone, Debug, Default, PartialEq)]
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

/// The binding of a monitored function, or of locations of it.
#[derive(Clone, Debug, PartialEq)]
pub struct Monitored {
    /// The function or location; its variables are those of `key`.
    pub location: LocationName,
    /// Origin of its value.
    pub from: Source,
    /// The messages that count as its value.
    pub receive: Receive,
    /// Path of the value in the message, for example `pose.position.x`. Without it, the message itself or its only
    /// field.
    pub field: Option<String>,
    /// Path of a text that names an enum literal; an alternative to `field`.
    pub map: Option<String>,
    /// The variables of the location, each with the path of the field that selects its element.
    pub key: Vec<(String, String)>,
    /// The values that fields of a message must have; other messages are refused.
    pub matching: Vec<(String, Argument)>,
    /// The texts for which a Boolean function is true. If empty, the value itself is used.
    pub is: Vec<String>,
    /// Value in a step without a message; undef if not given.
    pub none: Option<Constant>,
    /// Age in milliseconds after which the last message is stale; unlimited if not given.
    pub stale_ms: Option<u64>,
    /// Value if the last message is stale, or if there has been none.
    pub on_stale: Option<Constant>,
}

impl Monitored {
    /// Binds a function or location to a source, with the default of every optional setting.
    pub fn new(location: &str, from: Source) -> Self {
        Self {
            location: LocationName::from(location),
            from,
            receive: Receive::default(),
            field: None,
            map: None,
            key: Vec::new(),
            matching: Vec::new(),
            is: Vec::new(),
            none: None,
            stale_ms: None,
            on_stale: None,
        }
    }
}

/// Origin of a monitored function's value.
#[derive(Clone, Debug, PartialEq)]
pub enum Source {
    /// Messages on an input port, given by its name.
    Port(String),
    /// Requests for an operation that the component provides.
    Request(BoundOperation),
    /// True in the steps in which a condition has held for a time, without interruption since the step that made it
    /// true.
    Timer {
        /// The condition: a term of the specification.
        running: String,
        /// The time in milliseconds.
        ms: u64,
    },
    /// The number of messages lost on the way to an input port since the last step, or whether there were any.
    Losses(String),
    /// A constant.
    Value(Constant),
}

/// An operation that the component provides or calls; displayed as `service.operation`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct BoundOperation {
    /// Name of the component's service, or of its reference to one.
    pub service: String,
    /// Name of the operation within the interface.
    pub operation: String,
}

impl fmt::Display for BoundOperation {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}.{}", self.service, self.operation)
    }
}

/// The messages that count as the value of a step.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Word)]
pub enum Receive {
    /// The newest message, however old (TCA's `receiveLast`).
    #[default]
    Last,
    /// One message per step, in order; the others wait for the following steps (TCA's `receiveAll`).
    All,
    /// None: the value is `true` in steps in which a message arrived, and `false` in all others.
    Edge,
}

/// The binding of an out function, or of locations of it.
#[derive(Clone, Debug, PartialEq)]
pub struct Out {
    /// The function or location; its variables are those of the key of `effect`.
    pub location: LocationName,
    /// Effect of its updates.
    pub effect: Effect,
}

/// The effect of updates of an out function.
#[derive(Clone, Debug, PartialEq)]
pub enum Effect {
    /// Publishes the value itself.
    Publish(Published),
    /// Runs actions that depend on the literal; literals that are not listed have no effect, not even on calls under way.
    Literals(Vec<Case>),
}

/// The publication of the value of an out function.
#[derive(Clone, Debug, PartialEq)]
pub struct Published {
    /// Name of the output port.
    pub port: String,
    /// The field that takes the value. Without it, the message itself.
    pub field: Option<String>,
    /// The variables of the location, each with the path of the field that takes its element.
    pub key: Vec<(String, String)>,
    /// The steps after which it is published.
    pub when: PublishWhen,
}

/// The steps after which the value of an out function is published.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Word)]
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
#[derive(Clone, Debug, PartialEq)]
pub struct Case {
    /// The enum literal.
    pub literal: String,
    /// The actions, in order.
    pub actions: Vec<Action>,
}

/// An action of an update.
#[derive(Clone, Debug, PartialEq)]
#[expect(
    clippy::large_enum_variant,
    reason = "a coordinator has a handful of them, made once at its start"
)]
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
    /// Cancels the call under way that an earlier update of the function made, if the flag is set. Any other action cancels
    /// it as well.
    Cancel(bool),
}

/// A call of a service, whose outcome comes back as an event.
///
/// A later update of the same out function to a value with an action cancels the call, because its outcome would no longer be
/// relevant. An update to any other value leaves it under way, so that an out function may be set for a single step.
#[derive(Clone, Debug, PartialEq)]
pub struct Call {
    /// The operation of one of the component's references.
    pub operation: BoundOperation,
    /// The request; the default of its type, if empty.
    pub with: Argument,
    /// Name under which the response is kept for later arguments.
    pub keep: Option<String>,
    /// The monitored function or location that takes one of the following literals when the call ends.
    pub event: Option<String>,
    /// Literal for a response.
    pub ok: Option<String>,
    /// Literal for a fault whose code is not in `faults`.
    pub failed: Option<String>,
    /// Fault codes and their literals.
    pub faults: Vec<(String, String)>,
    /// Literal for a timeout; `failed` if not given.
    pub timeout: Option<String>,
    /// Literal for an unavailable provider; `failed` if not given.
    pub unavailable: Option<String>,
    /// The service whose request this call is made for: the caller gets the outcome as its reply.
    pub reply: Option<String>,
}

impl Call {
    /// Calls an operation with an empty request and ignores the outcome.
    pub fn new(operation: BoundOperation) -> Self {
        Self {
            operation,
            with: Argument::default(),
            keep: None,
            event: None,
            ok: None,
            failed: None,
            faults: Vec::new(),
            timeout: None,
            unavailable: None,
            reply: None,
        }
    }
}

/// The content of a message or request; an empty record, the default of each type, by default.
#[derive(Clone, Debug, PartialEq)]
pub enum Argument {
    /// A response that was kept, the newest message of an input port, the newest request of a service, or the newest message
    /// published on an output port.
    Kept {
        /// Name of the kept response, port or service.
        name: String,
        /// Path within it, for example `pose.position`; all of it if not given.
        path: Option<String>,
    },
    /// A record; omitted fields have their initial values.
    Record(Vec<(String, Argument)>),
    /// A literal value.
    Value(Constant),
    /// The value of a term of the specification, in the state after the step.
    Term(String),
}

impl Default for Argument {
    fn default() -> Self {
        Self::Record(Vec::new())
    }
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

/// Iterates over the terms of a binding.
pub(crate) fn terms(binding: &Binding) -> impl Iterator<Item = &str> {
    let timers = binding.monitored.iter().filter_map(|it| match &it.from {
        Source::Timer { running, .. } => Some(running.as_str()),
        Source::Port(_) | Source::Request(_) | Source::Losses(_) | Source::Value(_) => None,
    });
    let matching = binding.monitored.iter().flat_map(|it| &it.matching);
    let matching = matching.flat_map(|(_, value)| terms_of(value));
    timers
        .chain(matching)
        .chain(actions(binding).flat_map(|action| match action {
            Action::Call(call) => terms_of(&call.with),
            Action::Publish { value, .. } => terms_of(value),
            Action::Cancel(_) => Vec::new(),
        }))
}

fn terms_of(argument: &Argument) -> Vec<&str> {
    match argument {
        Argument::Term(term) => vec![term],
        Argument::Record(fields) => fields.iter().flat_map(|(_, it)| terms_of(it)).collect(),
        Argument::Kept { .. } | Argument::Value(_) => Vec::new(),
    }
}

/// The names of the responses, ports and services whose data a binding uses.
pub(crate) fn kept_names(binding: &Binding) -> BTreeSet<&str> {
    let matching = binding.monitored.iter().flat_map(|it| &it.matching);
    let arguments = actions(binding).filter_map(|action| match action {
        Action::Call(call) => Some(&call.with),
        Action::Publish { value, .. } => Some(value),
        Action::Cancel(_) => None,
    });
    let mut names = BTreeSet::new();
    for argument in arguments.chain(matching.map(|(_, value)| value)) {
        add_kept(argument, &mut names);
    }
    names
}

fn add_kept<'b>(argument: &'b Argument, names: &mut BTreeSet<&'b str>) {
    match argument {
        Argument::Kept { name, .. } => {
            names.insert(name);
        }
        Argument::Record(fields) => fields.iter().for_each(|(_, it)| add_kept(it, names)),
        Argument::Value(_) | Argument::Term(_) => {}
    }
}

fn actions(binding: &Binding) -> impl Iterator<Item = &Action> {
    let cases = binding.out.iter().flat_map(|out| match &out.effect {
        Effect::Literals(cases) => cases.as_slice(),
        Effect::Publish(_) => &[],
    });
    cases.flat_map(|case| &case.actions)
}

impl Binding {
    /// The calls of all updates, in order.
    pub fn calls(&self) -> impl Iterator<Item = &Call> {
        actions(self).filter_map(|action| match action {
            Action::Call(call) => Some(call),
            Action::Publish { .. } | Action::Cancel(_) => None,
        })
    }
}
