//! The travel of messages between the machines of a system.

use crate::decisions::Decisions;
use crate::mail::MessagePlan;
use crate::post::{DelayedMessage, ExpectedReply, PendingReply, Post, ReplyUse, ScriptedReply};
use crate::transition::{FaultCause, FullMailbox, MachineFault};
use crate::translation::translated;
use asmotion_lang::ir::ValueShape;
use asmotion_lang::machine::{CallFault, SentKind, SentMessage};
use asmotion_lang::stdlib::operation as operation_name;
use asmotion_lang::{Machine, Value};

/// Moves messages from and to machines.
pub(crate) struct MessageDelivery<'a> {
    pub plan: &'a MessagePlan,
    pub names: &'a [String],
    pub machines: &'a mut Vec<Machine>,
    pub post: &'a mut Post,
    pub decisions: &'a Decisions,
    /// Number of steps that are done.
    pub steps: usize,
    /// Events of messages, in words.
    pub events: &'a mut Vec<String>,
}

/// Messages that arrive at a machine before its step.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Arrivals {
    /// `true` if something arrives.
    pub is_any: bool,
    /// Bits of the label of the transition: what is not made to wait.
    pub label: u32,
}

impl Arrivals {
    /// Set if no call with a deadline waits, or one ends.
    pub const CALLS: u32 = 1 << 8;

    /// Set if no message of a sender waits, or one arrives.
    pub fn of_sender(sender: usize) -> u32 {
        1 << (9 + sender.min(22))
    }

    /// Set, in a step of several of so many machines, if no message between two of them waits, or one arrives; for a machine itself, as
    /// [`Arrivals::CALLS`]. With more than four machines, the last ones share a bit, which is set if one of theirs is: then less
    /// fairness is assumed.
    pub fn between(sender: usize, receiver: usize, machines: usize) -> u32 {
        1 << (8 + (receiver * machines + sender).min(23))
    }
}

impl MessageDelivery<'_> {
    /// Delivers what arrives at a machine before its step: delayed messages, ends of calls, and messages of partners outside the
    /// system.
    pub fn arrive(&mut self, index: usize) -> Arrivals {
        let mut arrivals = self.letters(index);
        arrivals.is_any |= self.scripted_replies(index);
        arrivals.label |= self.ends_of_calls(index, &mut arrivals.is_any);
        arrivals.is_any |= self.expected_replies(index);
        arrivals.is_any |= self.requests_from_outside(index);
        arrivals
    }

    /// Of each sender, a number of the letters under way arrives.
    fn letters(&mut self, index: usize) -> Arrivals {
        let mut arrivals = Arrivals::default();
        for sender in 0..self.machines.len() {
            let is_it = |letter: &&DelayedMessage| letter.from == sender && letter.to == index;
            let waiting = self.post.letters.iter().filter(is_it).count();
            let arriving = match waiting {
                0 => 0,
                waiting => self.decisions.decide(waiting + 1),
            };
            if waiting == 0 || arriving > 0 {
                arrivals.label |= Arrivals::of_sender(sender);
            }
            for _ in 0..arriving {
                let mut letters = self.post.letters.iter();
                let at = letters.position(|letter| is_it(&letter));
                if let Some(at) = at {
                    let letter = self.post.letters.remove(at);
                    self.event(format!("`{}` arrives", letter.operation), index);
                    self.deliver(letter);
                    arrivals.is_any = true;
                }
            }
        }
        arrivals
    }

    /// Each call with a deadline can time out; each call to a partner outside the system can end with a reply or a fault. Returns
    /// bits of the label.
    fn ends_of_calls(&mut self, index: usize, arrives: &mut bool) -> u32 {
        let Some(machine) = self.machines.get(index) else {
            return 0;
        };
        let (mut waits, mut ends) = (false, false);
        for call in machine.pending_calls() {
            // the script says when it ends
            if self.post.is_scripted(index, call.id) {
                continue;
            }
            let operation = operation_of(&call.operation);
            let mail = self.plan.machines.get(index);
            let asked = mail.and_then(|it| it.asked(&call.to, &operation));
            let is_played = self.plan.answer(&call.to, &operation).is_some();
            let is_outside = !is_played && asked.is_some_and(|it| it.provider.is_none());
            let mut outcomes: Vec<Result<Value, CallFault>> = Vec::new();
            if let (Some(asked), true) = (asked, is_outside) {
                outcomes.extend(asked.replies.iter().cloned().map(Ok));
                outcomes.extend([Err(CallFault::Unavailable), Err(CallFault::Failed)]);
            }
            if call.has_deadline {
                outcomes.push(Err(CallFault::Timeout));
            }
            if outcomes.is_empty() {
                continue;
            }
            let taken = self.decisions.decide(outcomes.len() + 1);
            let Some(outcome) = taken.checked_sub(1).and_then(|at| outcomes.get(at)) else {
                waits |= call.has_deadline;
                continue;
            };
            let what = match outcome {
                Ok(_) => format!("the reply to `{operation}` arrives"),
                Err(CallFault::Timeout) => format!("the call `{operation}` times out"),
                Err(_) => format!("the call `{operation}` fails"),
            };
            self.event(what, index);
            self.post.end_call(index, call.id);
            if let Some(machine) = self.machines.get_mut(index) {
                machine.end_call(call.id, outcome.clone());
                ends = true;
            }
        }
        *arrives |= ends;
        if waits && !ends { 0 } else { Arrivals::CALLS }
    }

    /// The replies of the script that are due arrive, or later if messages are delayed.
    fn scripted_replies(&mut self, index: usize) -> bool {
        let step = self.steps as u64 + 1;
        let mut arrives = false;
        for reply in std::mem::take(&mut self.post.scripted) {
            let is_due = reply.machine == index && reply.step <= step;
            if !is_due || self.plan.model.is_delayed && self.decisions.decide(2) == 1 {
                self.post.scripted.push(reply);
                continue;
            }
            let (Some(answer), Some(machine)) = (
                self.plan.scripted.get(reply.answer),
                self.machines.get_mut(index),
            ) else {
                continue;
            };
            let operation = &answer.operation;
            let what = match (&answer.outcome, reply.reply) {
                (outcome, ReplyUse::Call(call)) => {
                    machine.end_call(call, outcome.clone());
                    match outcome {
                        Ok(_) => format!("the reply to `{operation}` arrives"),
                        Err(_) => format!("the call `{operation}` fails"),
                    }
                }
                (Ok(data), ReplyUse::Message | ReplyUse::Ignored) => {
                    let partner = answer.partner.clone();
                    machine.deliver(partner, reply.agent, operation, data.clone());
                    format!("the reply to `{operation}` arrives")
                }
                (Err(_), ReplyUse::Message | ReplyUse::Ignored) => {
                    machine.set_unsent(reply.agent, operation);
                    format!("`{operation}` was not sent")
                }
            };
            arrives = true;
            self.event(what, index);
        }
        arrives
    }

    /// Partners outside the system reply to messages whose replies are received as messages.
    fn expected_replies(&mut self, index: usize) -> bool {
        let mut arrives = false;
        let expected = std::mem::take(&mut self.post.expected);
        for reply in expected {
            let mail = self.plan.machines.get(reply.machine);
            let asked = mail.and_then(|it| it.asked(&reply.partner, &reply.operation));
            let replies = asked.map(|it| it.replies.as_slice()).unwrap_or_default();
            if reply.machine != index || replies.is_empty() {
                self.post.expected.push(reply);
                continue;
            }
            // it comes later, comes now, or never: the message could not be sent
            let taken = self.decisions.decide(replies.len() + 2);
            let Some(machine) = self.machines.get_mut(index) else {
                continue;
            };
            match taken.checked_sub(1) {
                None => self.post.expected.push(reply),
                Some(at) => {
                    arrives = true;
                    match replies.get(at) {
                        Some(data) => {
                            let what = format!("the reply to `{}` arrives", reply.operation);
                            machine.deliver(
                                reply.partner,
                                reply.agent,
                                &reply.operation,
                                data.clone(),
                            );
                            self.event(what, index);
                        }
                        None => {
                            machine.set_unsent(reply.agent, &reply.operation);
                            self.event(format!("`{}` was not sent", reply.operation), index);
                        }
                    }
                }
            }
        }
        arrives
    }

    /// A client outside the system can request each operation, while the mailbox has room.
    fn requests_from_outside(&mut self, index: usize) -> bool {
        let Some(mail) = self.plan.machines.get(index) else {
            return false;
        };
        let mut arrives = false;
        for served in &mail.served {
            let is_full = self.waiting(index) >= self.plan.model.mailbox;
            if served.requests.is_empty() || is_full {
                continue;
            }
            let taken = self.decisions.decide(served.requests.len() + 1);
            let data = taken.checked_sub(1).and_then(|at| served.requests.get(at));
            if let (Some(data), Some(machine)) = (data, self.machines.get_mut(index)) {
                machine.deliver(Value::Undef, Value::Undef, &served.operation, data.clone());
                self.event(format!("the request `{}` arrives", served.operation), index);
                arrives = true;
            }
        }
        arrives
    }

    /// Sends the messages of a machine's last step. Returns `true` if there are any.
    ///
    /// # Errors
    /// A message does not fit into the mailbox of its receiver.
    pub fn send(&mut self, index: usize) -> Result<bool, MachineFault> {
        let Some(machine) = self.machines.get(index) else {
            return Ok(false);
        };
        let sent: Vec<SentMessage> = machine.last_step().sent().to_vec();
        for message in &sent {
            if message.leaves {
                self.send_one(index, message)?;
            }
        }
        if self.waiting(index) > self.plan.model.mailbox
            && let Some(own) = sent.iter().rev().find(|it| !it.leaves)
        {
            return Err(self.overflow(index, index, operation_of(&own.operation)));
        }
        Ok(!sent.is_empty())
    }

    fn send_one(&mut self, index: usize, message: &SentMessage) -> Result<(), MachineFault> {
        let operation = operation_of(&message.operation);
        match &message.kind {
            SentKind::Message { data } | SentKind::Call { data, .. } => {
                let is_call = matches!(message.kind, SentKind::Call { .. });
                self.request(index, message, operation, data, is_call)
            }
            SentKind::Reply { data, to } => {
                let mut exchanges = self.post.exchanges.iter();
                let known =
                    exchanges.position(|it| it.provider == index && Some(it.request) == *to);
                let Some(at) = known else {
                    return Ok(());
                };
                let exchange = self.post.exchanges.remove(at);
                let data = self.content(index, exchange.client, data, &operation, false);
                let letter = DelayedMessage {
                    from: index,
                    to: exchange.client,
                    is_reply: true,
                    reply: exchange.reply,
                    agent: exchange.agent,
                    partner: exchange.partner,
                    operation,
                    data: Value::Undef,
                };
                match data {
                    Some(data) => self.post_letter(DelayedMessage { data, ..letter }),
                    None => {
                        self.fail(&letter);
                        Ok(())
                    }
                }
            }
            SentKind::Cancel { call } => {
                self.post.end_call(index, *call);
                Ok(())
            }
        }
    }

    fn request(
        &mut self,
        index: usize,
        message: &SentMessage,
        operation: String,
        data: &Value,
        is_call: bool,
    ) -> Result<(), MachineFault> {
        if let Some(answer) = self.plan.answer(&message.to, &operation) {
            self.request_from_script(index, message, answer, is_call);
            return Ok(());
        }
        let mail = self.plan.machines.get(index);
        let Some(asked) = mail.and_then(|it| it.asked(&message.to, &operation)) else {
            return Ok(());
        };
        let Some(provider) = asked.provider else {
            if !is_call && !asked.replies.is_empty() {
                let expected = self.post.expected.iter();
                if expected.filter(|it| it.machine == index).count() >= self.plan.model.mailbox {
                    return Err(self.overflow(index, index, operation));
                }
                self.post.expected.push(ExpectedReply {
                    machine: index,
                    agent: message.from.clone(),
                    partner: message.to.clone(),
                    operation,
                });
            }
            return Ok(());
        };
        let own = self.machines.get(index).map(Machine::program);
        let reply = if is_call {
            ReplyUse::Call(message.id)
        } else if own.is_some_and(|program| program.operation(&operation).replies) {
            ReplyUse::Message
        } else {
            ReplyUse::Ignored
        };
        let content = self.content(index, provider, data, &operation, true);
        let letter = DelayedMessage {
            from: index,
            to: provider,
            is_reply: false,
            reply,
            agent: message.from.clone(),
            partner: message.to.clone(),
            operation,
            data: Value::Undef,
        };
        match content {
            Some(data) => self.post_letter(DelayedMessage { data, ..letter }),
            None => {
                self.fail(&letter);
                Ok(())
            }
        }
    }

    /// A request for a partner that the script plays: it is lost, or its reply is scheduled.
    fn request_from_script(
        &mut self,
        index: usize,
        message: &SentMessage,
        answer: usize,
        is_call: bool,
    ) {
        let Some(scripted) = self.plan.scripted.get(answer) else {
            return;
        };
        if self.plan.model.is_lossy && self.decisions.decide(2) == 1 {
            self.event(format!("`{}` is lost", scripted.operation), index);
            return;
        }
        self.post.scripted.push(ScriptedReply {
            machine: index,
            // the step that sends it is not counted yet
            step: (self.steps as u64 + 1).saturating_add(scripted.after),
            answer,
            agent: message.from.clone(),
            reply: if is_call {
                ReplyUse::Call(message.id)
            } else {
                ReplyUse::Message
            },
        });
    }

    /// Translates the content of a message for its receiver.
    fn content(
        &self,
        from: usize,
        to: usize,
        data: &Value,
        operation: &str,
        is_request: bool,
    ) -> Option<Value> {
        let (from, to) = (self.machines.get(from)?, self.machines.get(to)?);
        let known = to.program().operation(operation);
        let shape: ValueShape = if is_request { known.takes } else { known.gives };
        translated(data, from.program(), to.program(), &shape)
    }

    /// A message whose content its receiver does not understand: the call fails.
    fn fail(&mut self, letter: &DelayedMessage) {
        let client = letter.client();
        self.event(
            format!("the content of `{}` does not fit", letter.operation),
            client,
        );
        if let (ReplyUse::Call(call), Some(machine)) = (letter.reply, self.machines.get_mut(client))
        {
            machine.end_call(call, Err(CallFault::Failed));
        }
    }

    /// Sends a message: it is lost, arrives, or travels.
    fn post_letter(&mut self, letter: DelayedMessage) -> Result<(), MachineFault> {
        if self.plan.model.is_lossy && self.decisions.decide(2) == 1 {
            self.event(format!("`{}` is lost", letter.operation), letter.to);
            return Ok(());
        }
        if self.waiting(letter.to) >= self.plan.model.mailbox {
            return Err(self.overflow(letter.from, letter.to, letter.operation));
        }
        if self.plan.model.is_delayed {
            self.post.letters.push(letter);
        } else {
            self.deliver(letter);
        }
        Ok(())
    }

    /// Number of messages that wait for a machine.
    fn waiting(&self, index: usize) -> usize {
        let machine = self.machines.get(index);
        let arrived = machine.map_or(0, Machine::undelivered_messages);
        let letters = self.post.letters.iter().filter(|it| it.to == index);
        arrived + letters.count()
    }

    fn deliver(&mut self, letter: DelayedMessage) {
        let Some(machine) = self.machines.get_mut(letter.to) else {
            return;
        };
        if letter.is_reply {
            match letter.reply {
                ReplyUse::Call(call) => machine.end_call(call, Ok(letter.data)),
                ReplyUse::Message => {
                    machine.deliver(letter.partner, letter.agent, &letter.operation, letter.data);
                }
                ReplyUse::Ignored => {}
            }
            return;
        }
        let request = machine.deliver(Value::Undef, Value::Undef, &letter.operation, letter.data);
        let mail = self.plan.machines.get(letter.to);
        let is_answered = mail.is_some_and(|it| it.is_answered(&letter.operation));
        if is_answered && letter.reply != ReplyUse::Ignored {
            self.post.exchanges.push(PendingReply {
                client: letter.from,
                reply: letter.reply,
                agent: letter.agent,
                partner: letter.partner,
                operation: letter.operation,
                provider: letter.to,
                request,
            });
        }
    }

    fn overflow(&self, from: usize, to: usize, operation: String) -> MachineFault {
        let name = |index: usize| self.names.get(index).cloned().unwrap_or_default();
        MachineFault {
            machine: from,
            cause: FaultCause::Mailbox(Box::new(FullMailbox {
                sender: name(from),
                receiver: name(to),
                operation,
                bound: self.plan.model.mailbox,
            })),
        }
    }

    fn event(&mut self, what: String, machine: usize) {
        let name = self.names.get(machine).map_or("", |name| name.as_str());
        self.events.push(format!("{name}: {what}"));
    }
}

/// Name of an operation, without prefix and signature.
fn operation_of(operation: &Value) -> String {
    if let Value::Text(text) = operation {
        operation_name(text).to_owned()
    } else {
        String::new()
    }
}
