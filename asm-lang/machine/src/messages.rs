//! Messages between agents, from sending to receiving.
//!
//! They wait outside the ASM state. A step sees the messages that arrived before it, the oldest one
//! for each sender and operation; those that it sends arrive in the next step at the earliest. A
//! step can therefore send any number of messages in any order, and no message overwrites another.
//! (SCA-ASM: Riccobene and Scandurra, Formal Aspects of Computing 26, 2014.)

mod packed;
mod sent;
mod waiting;

pub use sent::{CallFault, MessageId, SentKind, SentMessage};
pub use waiting::PendingCall;

use asmotion_ir::{Messages, Origin};
use asmotion_stdlib::{MessageAction, MessageQuery};
use asmotion_value::Value;
use std::collections::BTreeMap;

/// Capacity of each queue. A further message displaces the oldest one, which is counted.
const MAX_WAITING: usize = 1024;

/// A millisecond in nanoseconds.
const MILLISECOND: i64 = 1_000_000;

/// An action on messages performed by an agent in a step.
#[derive(Debug)]
pub(crate) struct PerformedAction {
    pub action: MessageAction,
    pub arguments: Vec<Value>,
    pub origin: Origin,
}

/// A message in one of the queues.
#[derive(Clone, Debug)]
struct StoredMessage {
    id: MessageId,
    from: Value,
    to: Value,
    operation: Value,
    data: Value,
}

/// A call without a reply so far.
#[derive(Clone, Debug)]
struct WaitingCall {
    id: MessageId,
    from: Value,
    to: Value,
    operation: Value,
    deadline_ns: Option<i64>,
}

impl StoredMessage {
    fn translated(&self, translate: &dyn Fn(&Value) -> Option<Value>) -> Option<Self> {
        Some(Self {
            id: self.id,
            from: translate(&self.from)?,
            to: translate(&self.to)?,
            operation: self.operation.clone(),
            data: translate(&self.data)?,
        })
    }
}

/// The key of faults: an agent and the name of an operation.
type Concern = (Value, String);

/// The queues of a machine's messages, and the state of its calls.
#[derive(Clone, Debug, Default)]
pub(crate) struct MessagesInTransit {
    /// Agents outside this specification; messages to them leave it.
    partners: Vec<Value>,
    /// Messages not received yet, oldest first.
    undelivered: Vec<StoredMessage>,
    /// Requests received but not answered, oldest first.
    received: Vec<StoredMessage>,
    /// Replies not received yet, oldest first.
    answers: Vec<StoredMessage>,
    calls: Vec<WaitingCall>,
    faults: BTreeMap<Concern, CallFault>,
    /// Senders and operations of messages that could not be sent since the last step.
    unsent: Vec<Concern>,
    /// Calls that timed out; reported as cancelled with the next messages sent.
    ended: Vec<SentMessage>,
    is_down: bool,
    last: u64,
    dropped: u64,
}

/// The first three arguments of message actions and queries: the agent itself, its partner, and the
/// operation.
struct MessageRoute<'a> {
    own: &'a Value,
    partner: &'a Value,
    operation: &'a str,
}

impl<'a> MessageRoute<'a> {
    /// Reads the first three arguments.
    fn of(arguments: &'a [Value]) -> Option<Self> {
        let [own, other, operation, ..] = arguments else {
            return None;
        };
        Some(Self {
            own,
            partner: other,
            operation: name(operation)?,
        })
    }

    /// Returns `true` if the partner sent this message about the operation to the agent.
    fn is_from(&self, message: &StoredMessage) -> bool {
        message.to == *self.own
            && message.from == *self.partner
            && self.is_about(&message.operation)
    }

    /// Returns `true` if the agent made this call of the operation to the partner.
    fn is_of(&self, call: &WaitingCall) -> bool {
        call.from == *self.own && call.to == *self.partner && self.is_about(&call.operation)
    }

    fn is_about(&self, operation: &Value) -> bool {
        name(operation) == Some(self.operation)
    }

    fn concern(&self) -> Concern {
        (self.own.clone(), self.operation.to_owned())
    }
}

/// Returns the name of an operation, without prefix and signature.
fn name(operation: &Value) -> Option<&str> {
    if let Value::Text(text) = operation {
        Some(asmotion_stdlib::operation(text))
    } else {
        None
    }
}

impl MessagesInTransit {
    /// Ends the calls whose deadline has passed.
    pub fn begin_step(&mut self, now_ns: i64) {
        let is_over = |call: &mut WaitingCall| call.deadline_ns.is_some_and(|end| end <= now_ns);
        let over: Vec<WaitingCall> = self.calls.extract_if(.., is_over).collect();
        for call in over {
            self.record_fault(call, CallFault::Timeout);
        }
    }

    fn record_fault(&mut self, call: WaitingCall, fault: CallFault) {
        if let Some(operation) = name(&call.operation) {
            let concern = (call.from.clone(), operation.to_owned());
            self.faults.insert(concern, fault);
        }
        let cancelled = self.cancelled(call);
        self.ended.push(cancelled);
    }

    fn cancelled(&mut self, call: WaitingCall) -> SentMessage {
        SentMessage {
            id: self.number(),
            leaves: self.partners.contains(&call.to),
            from: call.from,
            to: call.to,
            operation: call.operation,
            kind: SentKind::Cancel { call: call.id },
        }
    }

    fn number(&mut self) -> MessageId {
        self.last += 1;
        MessageId(self.last)
    }

    /// Answers a query about messages. `None` leaves the answer to the environment.
    pub fn answer(
        &self,
        query: MessageQuery,
        arguments: &[Value],
        messages: &Messages,
        now_ns: i64,
    ) -> Option<Value> {
        let route = || MessageRoute::of(arguments);
        let concern = || match arguments {
            [agent, operation] => Some((agent.clone(), name(operation)?.to_owned())),
            _ => None,
        };
        let oldest = |to: &Value| self.undelivered.iter().find(|stored| stored.to == *to);
        match query {
            MessageQuery::Next => Some(oldest(arguments.first()?)?.operation.clone()),
            MessageQuery::Arrived => {
                let route = route()?;
                let mut queue = self.undelivered.iter();
                let stored = queue.find(|stored| route.is_from(stored))?;
                Some(stored.data.clone())
            }
            MessageQuery::Answered => {
                let route = route()?;
                let mut queue = self.answers.iter();
                let stored = queue.find(|stored| route.is_from(stored))?;
                Some(stored.data.clone())
            }
            MessageQuery::Calling => {
                let route = route()?;
                let calls = self.calls.iter().any(|call| route.is_of(call));
                Some(Value::Bool(calls))
            }
            MessageQuery::CallFault => {
                let fault = self.faults.get(&concern()?)?;
                Some(fault.value(messages))
            }
            MessageQuery::SendFault => self
                .unsent
                .contains(&concern()?)
                .then_some(Value::Bool(true)),
            MessageQuery::Channel => self.is_down.then(|| messages.unavailable.clone()),
            MessageQuery::Time => Some(Value::Int(now_ns.div_euclid(MILLISECOND))),
            MessageQuery::Client => {
                let agent = arguments.first().unwrap_or(&Value::Undef);
                let received = || self.received.iter().find(|stored| stored.to == *agent);
                let stored = oldest(agent).or_else(received)?;
                Some(stored.from.clone())
            }
        }
    }

    /// Returns the default answer of a query, for the case that neither the queues nor the
    /// environment has one.
    pub fn default_answer(query: MessageQuery, messages: &Messages) -> Value {
        match query {
            MessageQuery::SendFault | MessageQuery::Calling => Value::Bool(false),
            MessageQuery::Channel => messages.available.clone(),
            MessageQuery::Next
            | MessageQuery::Arrived
            | MessageQuery::Answered
            | MessageQuery::CallFault
            | MessageQuery::Time
            | MessageQuery::Client => Value::Undef,
        }
    }

    /// Performs the actions of a step's agents and appends the messages sent to `sent`.
    pub fn finish_step(
        &mut self,
        all: &[PerformedAction],
        now_ns: i64,
        sent: &mut Vec<SentMessage>,
    ) {
        self.unsent.clear();
        sent.append(&mut self.ended);
        for (index, done) in all.iter().enumerate() {
            // the same receive action performed twice in a step receives one message
            let is_again = all[..index]
                .iter()
                .any(|other| other.action == done.action && other.arguments == done.arguments);
            let Some(route) = MessageRoute::of(&done.arguments) else {
                continue;
            };
            match done.action {
                MessageAction::Send | MessageAction::Call | MessageAction::Reply => {
                    if let Some(message) = self.send(done, &route, now_ns) {
                        sent.push(message);
                    }
                }
                MessageAction::Take | MessageAction::Answer if is_again => {}
                MessageAction::Take => self.receive(&route),
                MessageAction::Answer => {
                    let stored = remove_first(&mut self.answers, |stored| route.is_from(stored));
                    if stored.is_none() {
                        // the reply came from the environment, as in a replay, so the call has
                        // ended
                        remove_first(&mut self.calls, |call| route.is_of(call));
                    }
                }
                MessageAction::Cancel => {
                    self.faults.remove(&route.concern());
                    self.answers.retain(|stored| !route.is_from(stored));
                    let calls: Vec<WaitingCall> = self
                        .calls
                        .extract_if(.., |call| route.is_of(call))
                        .collect();
                    for call in calls {
                        let cancelled = self.cancelled(call);
                        sent.push(cancelled);
                    }
                }
                MessageAction::Wait => {}
            }
        }
    }

    fn receive(&mut self, route: &MessageRoute<'_>) {
        if let Some(stored) = remove_first(&mut self.undelivered, |stored| route.is_from(stored)) {
            push_bounded(&mut self.received, stored, &mut self.dropped);
        }
    }

    fn send(
        &mut self,
        done: &PerformedAction,
        route: &MessageRoute<'_>,
        now_ns: i64,
    ) -> Option<SentMessage> {
        let (operation, data) = (
            done.arguments.get(2)?.clone(),
            done.arguments.get(3)?.clone(),
        );
        let id = self.number();
        let kind = match done.action {
            MessageAction::Call => {
                let deadline_ns = match done.arguments.get(4) {
                    Some(&Value::Int(ms)) if ms > 0 => {
                        Some(now_ns.saturating_add(ms.saturating_mul(MILLISECOND)))
                    }
                    _ => None,
                };
                self.calls.push(WaitingCall {
                    id,
                    from: route.own.clone(),
                    to: route.partner.clone(),
                    operation: operation.clone(),
                    deadline_ns,
                });
                SentKind::Call { data, deadline_ns }
            }
            MessageAction::Reply => {
                let request = remove_first(&mut self.received, |stored| route.is_from(stored));
                SentKind::Reply {
                    data,
                    to: request.map(|request| request.id),
                }
            }
            MessageAction::Send
            | MessageAction::Take
            | MessageAction::Answer
            | MessageAction::Wait
            | MessageAction::Cancel => SentKind::Message { data },
        };
        let message = SentMessage {
            id,
            from: route.own.clone(),
            to: route.partner.clone(),
            operation,
            kind,
            leaves: self.partners.contains(route.partner),
        };
        if !message.leaves {
            self.deliver_local(&message);
        }
        Some(message)
    }

    /// Queues a message for an agent of this specification.
    fn deliver_local(&mut self, message: &SentMessage) {
        let (data, answers) = match &message.kind {
            SentKind::Message { data } | SentKind::Call { data, .. } => (data, None),
            SentKind::Reply { data, to } => (data, *to),
            SentKind::Cancel { .. } => return,
        };
        let stored = StoredMessage {
            id: message.id,
            from: message.from.clone(),
            to: message.to.clone(),
            operation: message.operation.clone(),
            data: data.clone(),
        };
        let queue = match remove_first(&mut self.calls, |call| Some(call.id) == answers) {
            Some(_) => &mut self.answers,
            None => &mut self.undelivered,
        };
        push_bounded(queue, stored, &mut self.dropped);
    }

    /// Returns these messages with the values of another program and the partners of `other`; `None` if a value has no
    /// translation.
    pub fn translated(
        &self,
        other: &Self,
        translate: &dyn Fn(&Value) -> Option<Value>,
    ) -> Option<Self> {
        let stored = |queue: &[StoredMessage]| -> Option<Vec<_>> {
            let queue = queue.iter();
            queue.map(|stored| stored.translated(translate)).collect()
        };
        let calls = self.calls.iter().map(|call| {
            Some(WaitingCall {
                from: translate(&call.from)?,
                to: translate(&call.to)?,
                ..call.clone()
            })
        });
        let concern = |(agent, operation): &Concern| Some((translate(agent)?, operation.clone()));
        let faults = self.faults.iter();
        let faults = faults.map(|(key, fault)| Some((concern(key)?, *fault)));
        let ended = self.ended.iter().map(|it| it.translated(translate));
        Some(Self {
            partners: other.partners.clone(),
            undelivered: stored(&self.undelivered)?,
            received: stored(&self.received)?,
            answers: stored(&self.answers)?,
            calls: calls.collect::<Option<_>>()?,
            faults: faults.collect::<Option<_>>()?,
            unsent: self.unsent.iter().map(concern).collect::<Option<_>>()?,
            ended: ended.collect::<Option<_>>()?,
            is_down: self.is_down,
            last: self.last,
            dropped: self.dropped,
        })
    }

    // ---- interface to the outside --------------------------------------------------------------

    pub fn set_partners(&mut self, partners: Vec<Value>) {
        self.partners = partners;
    }

    pub fn deliver(&mut self, from: Value, to: Value, operation: Value, data: Value) -> MessageId {
        let id = self.number();
        let stored = StoredMessage {
            id,
            from,
            to,
            operation,
            data,
        };
        push_bounded(&mut self.undelivered, stored, &mut self.dropped);
        id
    }

    pub fn end_call(&mut self, id: MessageId, outcome: Result<Value, CallFault>) {
        let Some(call) = remove_first(&mut self.calls, |call| call.id == id) else {
            return;
        };
        match outcome {
            Ok(data) => {
                let stored = StoredMessage {
                    id,
                    from: call.to,
                    to: call.from,
                    operation: call.operation,
                    data,
                };
                push_bounded(&mut self.answers, stored, &mut self.dropped);
            }
            Err(fault) => {
                if let Some(operation) = name(&call.operation) {
                    self.faults.insert((call.from, operation.to_owned()), fault);
                }
            }
        }
    }

    pub fn set_unsent(&mut self, from: Value, operation: &str) {
        let operation = asmotion_stdlib::operation(operation).to_owned();
        self.unsent.push((from, operation));
    }

    pub fn set_down(&mut self, is_down: bool) {
        self.is_down = is_down;
    }

    pub fn dropped(&self) -> u64 {
        self.dropped
    }
}

fn remove_first<T>(list: &mut Vec<T>, is_it: impl Fn(&T) -> bool) -> Option<T> {
    let index = list.iter().position(is_it)?;
    Some(list.remove(index))
}

fn push_bounded(queue: &mut Vec<StoredMessage>, message: StoredMessage, dropped: &mut u64) {
    if queue.len() >= MAX_WAITING {
        queue.remove(0);
        *dropped += 1;
    }
    queue.push(message);
}
