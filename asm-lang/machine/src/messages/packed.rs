//! Packed form of messages, as part of a packed state.
//!
//! Ids are encoded relative to the last id. A machine that returns to the same situation therefore
//! has the same packed state, although its messages have new ids.

use super::{
    CallFault, MessageId, MessagesInTransit, SentKind, SentMessage, StoredMessage, WaitingCall,
};
use crate::packed::{Reader, Writer};
use asmotion_value::Value;

impl MessagesInTransit {
    /// Returns the id of the last message.
    pub fn last(&self) -> u64 {
        self.last
    }

    /// Writes everything that affects later steps.
    pub fn pack(&self, to: &mut Writer) {
        for queue in [&self.undelivered, &self.received, &self.answers] {
            to.count(queue.len());
            for stored in queue {
                self.pack_id(stored.id, to);
                to.values([&stored.from, &stored.to, &stored.operation, &stored.data].into_iter());
            }
        }
        to.count(self.calls.len());
        for call in &self.calls {
            self.pack_id(call.id, to);
            to.values([&call.from, &call.to, &call.operation].into_iter());
            pack_deadline(call.deadline_ns, to);
        }
        to.count(self.faults.len());
        for ((agent, operation), fault) in &self.faults {
            to.value(agent);
            to.text(operation);
            to.number(fault.number());
        }
        let mut unsent: Vec<_> = self.unsent.iter().collect();
        unsent.sort();
        unsent.dedup();
        to.count(unsent.len());
        for (agent, operation) in unsent {
            to.value(agent);
            to.text(operation);
        }
        to.count(self.ended.len());
        for sent in &self.ended {
            self.pack_sent(sent, to);
        }
        to.value(&Value::Bool(self.is_down));
    }

    fn pack_id(&self, id: MessageId, to: &mut Writer) {
        to.number(self.last.saturating_sub(id.0));
    }

    fn pack_sent(&self, sent: &SentMessage, to: &mut Writer) {
        self.pack_id(sent.id, to);
        to.values([&sent.from, &sent.to, &sent.operation].into_iter());
        to.value(&Value::Bool(sent.leaves));
        match &sent.kind {
            SentKind::Message { data } => {
                to.number(0);
                to.value(data);
            }
            SentKind::Call { data, deadline_ns } => {
                to.number(1);
                to.value(data);
                pack_deadline(*deadline_ns, to);
            }
            SentKind::Reply { data, to: request } => {
                to.number(2);
                to.value(data);
                to.value(&Value::Bool(request.is_some()));
                self.pack_id(request.unwrap_or(sent.id), to);
            }
            SentKind::Cancel { call } => {
                to.number(3);
                self.pack_id(*call, to);
            }
        }
    }

    /// Reads the output of [`MessagesInTransit::pack`]; `last` is the id of the machine's last
    /// message.
    pub fn unpack(from: &mut Reader<'_>, last: u64) -> Option<Self> {
        let mut post = Self {
            last,
            ..Self::default()
        };
        for queue in [&mut post.undelivered, &mut post.received, &mut post.answers] {
            for _ in 0..from.count()? {
                queue.push(message(from, last)?);
            }
        }
        for _ in 0..from.count()? {
            let id = id(from, last)?;
            let [from_agent, to, operation] = three(from)?;
            post.calls.push(WaitingCall {
                id,
                from: from_agent,
                to,
                operation,
                deadline_ns: deadline(from)?,
            });
        }
        for _ in 0..from.count()? {
            let concern = (from.value()?, from.text()?);
            post.faults.insert(concern, CallFault::of(from.number()?)?);
        }
        for _ in 0..from.count()? {
            post.unsent.push((from.value()?, from.text()?));
        }
        for _ in 0..from.count()? {
            post.ended.push(sent(from, last)?);
        }
        post.is_down = truth(from)?;
        Some(post)
    }

    /// Replaces all messages, but keeps the partners and the count of dropped messages.
    pub fn replace_messages(&mut self, other: Self) {
        let partners = std::mem::take(&mut self.partners);
        let dropped = self.dropped;
        *self = Self {
            partners,
            dropped,
            ..other
        };
    }
}

fn pack_deadline(deadline_ns: Option<i64>, to: &mut Writer) {
    to.value(&deadline_ns.map_or(Value::Undef, Value::Int));
}

fn deadline(from: &mut Reader<'_>) -> Option<Option<i64>> {
    let value = from.value()?;
    if let Value::Int(deadline) = value {
        Some(Some(deadline))
    } else {
        value.is_undef().then_some(None)
    }
}

fn id(from: &mut Reader<'_>, last: u64) -> Option<MessageId> {
    last.checked_sub(from.number()?).map(MessageId)
}

fn three(from: &mut Reader<'_>) -> Option<[Value; 3]> {
    from.values()?.try_into().ok()
}

fn truth(from: &mut Reader<'_>) -> Option<bool> {
    if let Value::Bool(truth) = from.value()? {
        Some(truth)
    } else {
        None
    }
}

fn message(from: &mut Reader<'_>, last: u64) -> Option<StoredMessage> {
    let id = id(from, last)?;
    let values: [Value; 4] = from.values()?.try_into().ok()?;
    let [from, to, operation, data] = values;
    Some(StoredMessage {
        id,
        from,
        to,
        operation,
        data,
    })
}

fn sent(from: &mut Reader<'_>, last: u64) -> Option<SentMessage> {
    let own = id(from, last)?;
    let [sender, to, operation] = three(from)?;
    let leaves = truth(from)?;
    let kind = match from.number()? {
        0 => SentKind::Message {
            data: from.value()?,
        },
        1 => SentKind::Call {
            data: from.value()?,
            deadline_ns: deadline(from)?,
        },
        2 => {
            let data = from.value()?;
            let is_known = truth(from)?;
            let request = id(from, last)?;
            SentKind::Reply {
                data,
                to: is_known.then_some(request),
            }
        }
        3 => SentKind::Cancel {
            call: id(from, last)?,
        },
        _ => return None,
    };
    Some(SentMessage {
        id: own,
        from: sender,
        to,
        operation,
        kind,
        leaves,
    })
}
