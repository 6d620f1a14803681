//! Messages of a system that no machine holds: on their way, and requests whose replies are expected.

use asmotion_lang::machine::{MessageId, pack_value};
use asmotion_lang::{Machine, Value};

/// The use that a client makes of the reply to a request.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum ReplyUse {
    /// A call with this id waits for it.
    Call(MessageId),
    /// It arrives as a message.
    Message,
    /// It is not awaited, or not any more.
    Ignored,
}

/// A request that a machine has received for another one.
#[derive(Clone, Debug)]
pub(crate) struct PendingReply {
    pub client: usize,
    pub reply: ReplyUse,
    /// The agent of the client that sent the request, and the one that stands for the partner.
    pub agent: Value,
    pub partner: Value,
    pub operation: String,
    pub provider: usize,
    /// Id of the request in the provider.
    pub request: MessageId,
}

/// A message that has not arrived yet.
#[derive(Clone, Debug)]
pub(crate) struct DelayedMessage {
    pub from: usize,
    pub to: usize,
    pub is_reply: bool,
    pub reply: ReplyUse,
    /// The agents of the client: its own, and the partner.
    pub agent: Value,
    pub partner: Value,
    pub operation: String,
    /// The content, as a value of the receiver.
    pub data: Value,
}

impl DelayedMessage {
    /// Returns the machine that made the request.
    pub fn client(&self) -> usize {
        if self.is_reply { self.to } else { self.from }
    }
}

/// A reply that a machine expects as a message of a partner outside the system.
#[derive(Clone, Debug)]
pub(crate) struct ExpectedReply {
    pub machine: usize,
    pub agent: Value,
    pub partner: Value,
    pub operation: String,
}

/// A reply of a partner that a script plays.
#[derive(Clone, Debug)]
pub(crate) struct ScriptedReply {
    pub machine: usize,
    /// Number of the step before which it arrives, from 1.
    pub step: u64,
    /// Index of the scripted reply.
    pub answer: usize,
    /// The agent that sent the request.
    pub agent: Value,
    pub reply: ReplyUse,
}

/// The messages that no machine holds.
#[derive(Clone, Debug, Default)]
pub(crate) struct Post {
    /// Oldest first.
    pub letters: Vec<DelayedMessage>,
    pub exchanges: Vec<PendingReply>,
    pub expected: Vec<ExpectedReply>,
    /// In the order of their requests.
    pub scripted: Vec<ScriptedReply>,
}

impl Post {
    /// Returns `true` if the script has a reply to a call.
    pub fn is_scripted(&self, machine: usize, call: MessageId) -> bool {
        let mut scripted = self.scripted.iter();
        scripted.any(|it| it.machine == machine && it.reply == ReplyUse::Call(call))
    }

    /// Applies the new numbers of a machine's messages, and forgets what refers to messages that are no longer known.
    pub fn renumber(&mut self, machine: usize, known: &[(MessageId, MessageId)]) {
        let new = |id: MessageId| {
            let mut known = known.iter();
            known.find(|(old, _)| *old == id).map(|(_, new)| *new)
        };
        self.exchanges.retain_mut(|it| {
            if it.client == machine
                && let ReplyUse::Call(call) = it.reply
            {
                match new(call) {
                    Some(id) => it.reply = ReplyUse::Call(id),
                    None => return false,
                }
            }
            if it.provider == machine {
                match new(it.request) {
                    Some(id) => it.request = id,
                    None => return false,
                }
            }
            true
        });
        self.letters.retain_mut(|it| {
            let ReplyUse::Call(call) = it.reply else {
                return true;
            };
            if it.client() != machine {
                return true;
            }
            let known = new(call);
            it.reply = known.map_or(ReplyUse::Ignored, ReplyUse::Call);
            // a late reply has no effect, but a late request is received
            known.is_some() || !it.is_reply
        });
        self.scripted.retain_mut(|it| {
            if let ReplyUse::Call(call) = it.reply
                && it.machine == machine
            {
                match new(call) {
                    Some(id) => it.reply = ReplyUse::Call(id),
                    None => return false,
                }
            }
            true
        });
        // their order has no effect
        self.exchanges
            .sort_by_key(|it| (it.provider, it.request, it.client));
    }

    /// Ends a call: its reply comes too late.
    pub fn end_call(&mut self, machine: usize, call: MessageId) {
        let is_it =
            |client: usize, reply: ReplyUse| client == machine && reply == ReplyUse::Call(call);
        self.exchanges.retain(|it| !is_it(it.client, it.reply));
        self.scripted.retain(|it| !is_it(it.machine, it.reply));
        self.letters
            .retain(|it| !(it.is_reply && is_it(it.client(), it.reply)));
        for letter in &mut self.letters {
            if is_it(letter.client(), letter.reply) {
                letter.reply = ReplyUse::Ignored;
            }
        }
    }

    /// Writes everything that affects later steps. The machines have been renumbered.
    pub fn pack(&self, machines: &[Machine], to: &mut Vec<u8>) {
        let mut writer = ByteWriter { machines, to };
        writer.number(self.letters.len() as u64);
        for letter in &self.letters {
            writer.number(letter.from as u64);
            writer.number(letter.to as u64);
            writer.number(u64::from(letter.is_reply));
            writer.reply(letter.client(), letter.reply);
            writer.value(&letter.agent);
            writer.value(&letter.partner);
            writer.text(&letter.operation);
            writer.value(&letter.data);
        }
        writer.number(self.exchanges.len() as u64);
        for exchange in &self.exchanges {
            writer.number(exchange.client as u64);
            writer.reply(exchange.client, exchange.reply);
            writer.value(&exchange.agent);
            writer.value(&exchange.partner);
            writer.text(&exchange.operation);
            writer.number(exchange.provider as u64);
            writer.id(exchange.provider, exchange.request);
        }
        writer.number(self.expected.len() as u64);
        for expected in &self.expected {
            writer.number(expected.machine as u64);
            writer.value(&expected.agent);
            writer.value(&expected.partner);
            writer.text(&expected.operation);
        }
        writer.number(self.scripted.len() as u64);
        for scripted in &self.scripted {
            writer.number(scripted.machine as u64);
            writer.number(scripted.step);
            writer.number(scripted.answer as u64);
            writer.value(&scripted.agent);
            writer.reply(scripted.machine, scripted.reply);
        }
    }

    /// Reads the output of [`Post::pack`]; the machines are in the same state.
    pub fn unpack(from: &mut ByteReader<'_>, machines: &[Machine]) -> Option<Self> {
        let mut post = Self::default();
        for _ in 0..from.number()? {
            let (sender, to) = (from.index()?, from.index()?);
            let is_reply = from.number()? == 1;
            let client = machines.get(if is_reply { to } else { sender })?;
            post.letters.push(DelayedMessage {
                from: sender,
                to,
                is_reply,
                reply: from.reply(client)?,
                agent: from.value(client)?,
                partner: from.value(client)?,
                operation: from.text()?,
                data: from.value(machines.get(to)?)?,
            });
        }
        for _ in 0..from.number()? {
            let client = from.index()?;
            let machine = machines.get(client)?;
            let (reply, agent, partner) = (
                from.reply(machine)?,
                from.value(machine)?,
                from.value(machine)?,
            );
            let operation = from.text()?;
            let provider = from.index()?;
            post.exchanges.push(PendingReply {
                client,
                reply,
                agent,
                partner,
                operation,
                provider,
                request: from.id(machines.get(provider)?)?,
            });
        }
        for _ in 0..from.number()? {
            let machine = from.index()?;
            let known = machines.get(machine)?;
            post.expected.push(ExpectedReply {
                machine,
                agent: from.value(known)?,
                partner: from.value(known)?,
                operation: from.text()?,
            });
        }
        for _ in 0..from.number()? {
            let machine = from.index()?;
            let known = machines.get(machine)?;
            post.scripted.push(ScriptedReply {
                machine,
                step: from.number()?,
                answer: from.index()?,
                agent: from.value(known)?,
                reply: from.reply(known)?,
            });
        }
        Some(post)
    }
}

/// Writes numbers, values and message ids.
struct ByteWriter<'a> {
    machines: &'a [Machine],
    to: &'a mut Vec<u8>,
}

impl ByteWriter<'_> {
    fn number(&mut self, number: u64) {
        write_number(number, self.to);
    }

    fn text(&mut self, text: &str) {
        self.number(text.len() as u64);
        self.to.extend_from_slice(text.as_bytes());
    }

    fn value(&mut self, value: &Value) {
        let bytes = pack_value(value);
        self.number(bytes.len() as u64);
        self.to.extend_from_slice(&bytes);
    }

    /// Writes an id relative to the last one of its machine, which a restored machine numbers differently.
    fn id(&mut self, machine: usize, id: MessageId) {
        let last = self.machines.get(machine).map(Machine::last_message);
        self.number(last.map_or(0, |last| last.0.saturating_sub(id.0)));
    }

    fn reply(&mut self, machine: usize, reply: ReplyUse) {
        match reply {
            ReplyUse::Ignored => self.number(0),
            ReplyUse::Message => self.number(1),
            ReplyUse::Call(id) => {
                self.number(2);
                self.id(machine, id);
            }
        }
    }
}

/// Writes a number, in groups of seven bits.
pub(crate) fn write_number(mut number: u64, to: &mut Vec<u8>) {
    while number >= 0x80 {
        to.push(number as u8 | 0x80);
        number >>= 7;
    }
    to.push(number as u8);
}

/// Reads what [`write_number`] and [`Post::pack`] wrote.
pub(crate) struct ByteReader<'a>(pub &'a [u8]);

impl<'a> ByteReader<'a> {
    pub fn number(&mut self) -> Option<u64> {
        let mut number = 0;
        for shift in (0..64).step_by(7) {
            let (byte, rest) = self.0.split_first()?;
            self.0 = rest;
            number |= u64::from(byte & 0x7f) << shift;
            if *byte < 0x80 {
                return Some(number);
            }
        }
        None
    }

    pub fn index(&mut self) -> Option<usize> {
        usize::try_from(self.number()?).ok()
    }

    pub fn block(&mut self) -> Option<&'a [u8]> {
        let count = self.index()?;
        let (block, rest) = self.0.split_at_checked(count)?;
        self.0 = rest;
        Some(block)
    }

    pub fn text(&mut self) -> Option<String> {
        String::from_utf8(self.block()?.to_vec()).ok()
    }

    pub fn value(&mut self, machine: &Machine) -> Option<Value> {
        machine.unpack_value(self.block()?).ok()
    }

    fn id(&mut self, machine: &Machine) -> Option<MessageId> {
        let before = self.number()?;
        machine.last_message().0.checked_sub(before).map(MessageId)
    }

    fn reply(&mut self, machine: &Machine) -> Option<ReplyUse> {
        Some(match self.number()? {
            0 => ReplyUse::Ignored,
            1 => ReplyUse::Message,
            _ => ReplyUse::Call(self.id(machine)?),
        })
    }
}
