//! Messages that wait in a machine, for an exploration of its states.

use super::{MessageId, MessagesInTransit, StoredMessage, name};
use asmotion_value::Value;

/// A call without a reply so far.
#[derive(Clone, Debug, PartialEq)]
pub struct PendingCall {
    /// Id of the message that made the call.
    pub id: MessageId,
    /// The calling agent.
    pub from: Value,
    /// The called agent.
    pub to: Value,
    /// The operation as written in the specification.
    pub operation: Value,
    /// `true` if the call fails at some time.
    pub has_deadline: bool,
}

impl MessagesInTransit {
    /// Lists the calls without a reply, oldest first.
    pub fn pending_calls(&self) -> Vec<PendingCall> {
        let calls = self.calls.iter().map(|call| PendingCall {
            id: call.id,
            from: call.from.clone(),
            to: call.to.clone(),
            operation: call.operation.clone(),
            has_deadline: call.deadline_ns.is_some(),
        });
        calls.collect()
    }

    /// Returns the number of messages and replies that no agent has received.
    pub fn undelivered(&self) -> usize {
        self.undelivered.len() + self.answers.len()
    }

    /// Forgets requests whose reply nothing can observe, and numbers the others from 1 in the order of the queues. Returns the
    /// new id of each message that is still known.
    pub fn renumber(&mut self, is_answered: &dyn Fn(&str) -> bool) -> Vec<(MessageId, MessageId)> {
        let mut kept: Vec<StoredMessage> = Vec::new();
        for request in std::mem::take(&mut self.received) {
            let is_answered = |it: &StoredMessage| name(&it.operation).is_some_and(is_answered);
            // a function with `@Backref` shows the sender of the first one, which is never removed
            let is_hidden = !is_answered(&request)
                && kept
                    .iter()
                    .any(|it| it.to == request.to && !is_answered(it));
            if !is_hidden {
                kept.push(request);
            }
        }
        self.received = kept;
        let queues = [&mut self.undelivered, &mut self.received, &mut self.answers];
        let ids = queues.into_iter().flatten().map(|it| &mut it.id);
        let ids = ids.chain(self.calls.iter_mut().map(|call| &mut call.id));
        let mut known: Vec<(MessageId, MessageId)> = Vec::new();
        let mut next = 0;
        for id in ids {
            // a request and the call that waits for its reply have the same id
            let new = match known.iter().find(|(old, _)| old == id) {
                Some((_, new)) => *new,
                None => {
                    next += 1;
                    known.push((*id, MessageId(next)));
                    MessageId(next)
                }
            };
            *id = new;
        }
        self.last = next;
        known
    }
}
