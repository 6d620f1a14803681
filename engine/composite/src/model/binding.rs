//! The binding of an ASM component as written. It resolves into the [`Binding`](asmotion_coordinator::Binding) of the
//! coordinator, whose types have the same fields without source spans.

use asmotion_derive::Table;
use asmotion_diagnostics::Span;

use asmotion_coordinator::{self as coordinator, PublishWhen, Receive};

use super::component::MessagePath;
use super::limits::DAY_MS;
use super::wiring::End;
use crate::at::At;
use crate::table::NamedValue;
use crate::tree::Node;

/// Bindings of the functions of an ASM to ports and services.
#[derive(Clone, Debug, Default, Table)]
#[table(
    of = "`bind`",
    example = "{ monitored = { }, out = { } }",
    into = coordinator::Binding
)]
pub struct Bind {
    /// Sources of the values of monitored functions.
    #[key(example = "{ }")]
    pub monitored: Vec<Monitored>,
    /// Actions triggered by updates of out functions.
    #[key(example = "{ }")]
    pub out: Vec<Out>,
}

impl Bind {
    /// Iterates over all calls.
    pub fn calls(&self) -> impl Iterator<Item = &Call> {
        let cases = self.out.iter().flat_map(|out| match &out.effect {
            Effect::Publish(_) => &[],
            Effect::Literals(cases) => cases.as_slice(),
        });
        cases
            .flat_map(|(_, actions)| actions)
            .filter_map(|action| match action {
                Action::Call(call) => Some(call.as_ref()),
                Action::Publish { .. } | Action::Cancel(_) => None,
            })
    }
}

/// The binding of a monitored function, or of locations of it.
#[derive(Clone, Debug, Table)]
#[table(
    of = "a bound monitored function",
    example = "{ topic = \"estop\", field = \"data\" }",
    into = coordinator::Monitored,
    after = super::binding_value::monitored
)]
pub struct Monitored {
    /// The function in the specification, or a location such as `wants(ROB1)`; `wants($r)` stands for all elements.
    #[key(entry = any)]
    pub location: At<String>,
    /// Topic or service that supplies the value.
    #[key(flatten)]
    pub from: Source,
    /// The messages that count as the value of a step.
    #[key(or_default)]
    pub receive: Option<At<Receive>>,
    /// The same as `receive = "edge"`.
    #[key(written)]
    pub edge: Option<At<bool>>,
    /// The part of the message that is the value; its only field, `data` or `code`, if absent.
    #[key(example = "\"data\"")]
    pub field: Option<MessagePath>,
    /// The field whose text names an enum literal.
    #[key(example = "\"data\"")]
    pub map: Option<MessagePath>,
    /// For each variable of the location, the field whose value selects the element.
    #[key(example = "{ r = \"robot\" }")]
    pub key: Vec<NamedValue<MessagePath>>,
    /// For each field, the value that a message must have: a constant, `@name` or `@(term)`. Other messages are refused.
    #[key(name = "where", example = "{ plan = \"@plan.header.stamp\" }")]
    pub matching: Vec<NamedValue<Argument>>,
    /// Field values for which the function is true.
    #[key(example = "\"idle\"")]
    pub is: Vec<At<String>>,
    /// The value in a step without a message.
    pub none: Option<Node>,
    /// Maximum age of the last message; unlimited by default.
    #[key(unit = "milliseconds", range = 1..=DAY_MS)]
    pub stale_ms: Option<At<u64>>,
    /// Value if the last message is stale, or if there has been none.
    pub on_stale: Option<Node>,
}

impl Monitored {
    /// Returns the receive mode; the default if none is written.
    pub fn received(&self) -> At<Receive> {
        let last = || At::new(Receive::default(), self.location.span);
        self.receive.clone().unwrap_or_else(last)
    }
}

/// Source of the value of a monitored function.
#[derive(Clone, Debug, Table)]
#[table(
    of = "a bound monitored function",
    reason = "a value comes from one source",
    into = coordinator::Source
)]
pub enum Source {
    /// A name under `subscribe` or `ports.in`.
    #[key(name = "topic", example = "\"estop\"")]
    Port(At<String>),
    /// `service.operation`: requests that the component answers; the `component` of the end is the service.
    #[key(name = "service", example = "\"move.moveTo\"")]
    Request(End),
    /// True once a condition of the specification has held for `ms`.
    Timer {
        /// The condition, a term of the specification: the timer starts with the step that makes it true, and stops
        /// when it no longer holds.
        #[key(name = "timer", example = "\"mode = CHARGING\"")]
        running: At<String>,
        /// Time after which the function is true.
        #[key(unit = "milliseconds", range = 1..=DAY_MS)]
        ms: At<u64>,
    },
    /// A name under `subscribe` or `ports.in`: the number of messages lost on the way to it since the last step or, for a
    /// Boolean function, whether there were any.
    #[key(name = "lost", example = "\"event\"")]
    Losses(At<String>),
    /// A constant, such as a list of waypoints.
    #[key(name = "value", example = "[1, 2, 3]")]
    Value(Node),
}

/// Binding of an out function, or of locations of it.
#[derive(Clone, Debug)]
pub struct Out {
    /// The function in the specification, or a location such as `command(ARM1)`; `command($a)` stands for all elements.
    pub location: At<String>,
    /// Effect of its updates.
    pub effect: Effect,
}

/// Effect of the updates of an out function.
#[derive(Clone, Debug)]
pub enum Effect {
    /// The value is published.
    Publish(Published),
    /// Actions by literal of the codomain.
    Literals(Vec<(At<String>, Vec<Action>)>),
}

/// Publication of the value of an out function.
#[derive(Clone, Debug, Table)]
#[table(
    of = "a bound out function",
    example = "{ topic = \"command\", publish = \"on_update\" }",
    into = coordinator::Published
)]
pub struct Published {
    /// The name under `publish` or `ports.out`.
    #[key(name = "topic", example = "\"command\"")]
    pub port: At<String>,
    /// Message field that receives the value; fields of a topic with the same key are sent in one message.
    #[key(example = "\"data\"")]
    pub field: Option<MessagePath>,
    /// For each variable of the location, the field that takes the element.
    #[key(example = "{ a = \"arm\" }")]
    pub key: Vec<NamedValue<MessagePath>>,
    /// The steps after which it is published.
    #[key(name = "publish", or_default)]
    pub when: Option<At<PublishWhen>>,
}

/// Action triggered by an update to a literal.
#[derive(Clone, Debug, Table)]
#[table(
    of = "an action",
    example = "{ call = \"planner.plan\", ok = \"PATH_OK\", event = \"ev\" }",
    reason = "an action has one effect; use a list for several",
    into = coordinator::Action
)]
pub enum Action {
    /// Calls a service.
    #[key(flatten)]
    Call(Box<Call>),
    /// Publishes a message.
    Publish {
        /// Publishes a message: the name under `publish` or `ports.out`.
        #[key(name = "publish", example = "\"plan\"")]
        port: At<String>,
        /// Content of the message: a literal value, a record, `@name` or `@(term)`.
        #[key(example = "\"@path\"")]
        value: Argument,
    },
    /// `true` cancels the call under way that an earlier update of the function made. Updates to values without an action leave
    /// it under way; those to values with another action cancel it as well.
    #[key(name = "cancel", example = "true")]
    Cancel(At<bool>),
}

/// A call of a service.
#[derive(Clone, Debug, Table)]
#[table(
    of = "an action",
    into = coordinator::Call,
    after = super::binding_value::call
)]
pub struct Call {
    /// Calls a service: `reference.operation`; the `component` of the end is the reference.
    #[key(name = "call", example = "\"planner.plan\"")]
    pub operation: End,
    /// The request.
    #[key(or_default)]
    pub with: Option<Argument>,
    /// Name under which the reply is kept.
    #[key(example = "\"path\"")]
    pub keep: Option<At<String>>,
    /// Literal of `event` for a reply.
    #[key(example = "\"PATH_OK\"")]
    pub ok: Option<At<String>>,
    /// Literal for a fault whose code is not in `faults`.
    #[key(example = "\"CALL_FAILED\"")]
    pub failed: Option<At<String>>,
    /// Literals by fault code, such as the planner's `NO_PATH`.
    #[key(example = "{ NO_PATH = \"UNREACHABLE\" }")]
    pub faults: Vec<NamedValue<At<String>>>,
    /// Literal for a reply that did not come in time; `failed`, if absent.
    #[key(example = "\"CALL_FAILED\"")]
    pub timeout: Option<At<String>>,
    /// Literal for no provider; `failed`, if absent.
    #[key(example = "\"NOBODY_THERE\"")]
    pub unavailable: Option<At<String>>,
    /// Monitored function or location that takes these literals.
    #[key(example = "\"ev\"")]
    pub event: Option<At<String>>,
    /// Service whose pending request is completed with the outcome of this call.
    #[key(example = "\"move\"")]
    pub reply: Option<At<String>>,
}

impl Call {
    /// Iterates over the literals of `event` that report the outcome.
    pub fn literals(&self) -> impl Iterator<Item = &At<String>> {
        let single = [&self.ok, &self.failed, &self.timeout, &self.unavailable];
        let faults = self.faults.iter().map(|fault| &fault.value);
        single.into_iter().flatten().chain(faults)
    }
}

/// Content of a message or argument of a call.
#[derive(Clone, Debug)]
pub enum Argument {
    /// `"@name"` or `"@name.field"`: a kept reply or the last message of a topic.
    Kept {
        /// Reply or topic name.
        name: At<String>,
        /// Field path within it; empty for all of it.
        path: Vec<At<String>>,
    },
    /// A record given field by field; omitted fields have their default.
    Record(Span, Vec<(At<String>, Argument)>),
    /// `"@(term)"`: the value of a term of the specification.
    Term(At<String>),
    /// Any other value; strings may contain substitutions.
    Value(Node),
}
