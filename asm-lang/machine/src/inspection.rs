//! Questions about a machine between two steps, and the form of its messages that does not depend on their history.

use crate::machine::Machine;
use crate::messages::{MessageId, PendingCall};
use asmotion_ir::FunctionId;
use asmotion_value::Value;

impl Machine {
    /// Returns the value of a location, also of one that was never accessed.
    pub fn value_at(&self, function: FunctionId, arguments: &[Value]) -> Value {
        if let Some(slot) = self.state.slot(&self.program, function, arguments) {
            return self.state.get(slot).clone();
        }
        self.clone().interned_value(function, arguments)
    }

    /// Returns the value that a location had before the last step.
    pub fn value_before(&self, function: FunctionId, arguments: &[Value]) -> Value {
        let slot = self.state.slot(&self.program, function, arguments);
        let step = self.last_step();
        let mut updates = step.updates().iter().zip(step.before());
        match updates.find(|(update, _)| Some(update.slot) == slot) {
            Some((_, before)) => before.clone(),
            None => self.value_at(function, arguments),
        }
    }

    /// Lists the calls without a reply, oldest first.
    pub fn pending_calls(&self) -> Vec<PendingCall> {
        self.messages.pending_calls()
    }

    /// Returns the number of messages and replies that have arrived and that no agent has received.
    pub fn undelivered_messages(&self) -> usize {
        self.messages.undelivered()
    }

    /// Returns the id of the last message.
    pub fn last_message(&self) -> MessageId {
        MessageId(self.messages.last())
    }

    /// Numbers the messages again, from 1, so that the packed state does not depend on the messages before them. Forgets received
    /// requests of operations that are not answered, as far as the specification cannot observe them. Returns the old and the
    /// new id of each message that is still known.
    pub fn renumber_messages(
        &mut self,
        is_answered: &dyn Fn(&str) -> bool,
    ) -> Vec<(MessageId, MessageId)> {
        self.messages.renumber(is_answered)
    }
}
