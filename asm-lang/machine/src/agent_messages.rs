//! Messages during a step: answers to queries, and the status of agents that received messages.

use crate::messages::{MessagesInTransit, PerformedAction};
use crate::record::StepInput;
use crate::run::{CodomainCheck, RuleStopped, StepContext};
use asmotion_ir::{Messages, Slot};
use asmotion_stdlib::{MessageAction, MessageQuery};
use asmotion_value::Value;

impl StepContext<'_> {
    /// Returns the value of a query about messages whose arguments are on the stack from
    /// `first_argument` on. Only a value that differs from the default (no message) is recorded as an
    /// input.
    pub fn message_query(
        &mut self,
        slot: Slot,
        query: MessageQuery,
        messages: &Messages,
        first_argument: usize,
    ) -> Value {
        let arguments = &self.stack[first_argument..];
        let answer = self
            .messages
            .answer(query, arguments, messages, self.now_ns);
        // traces and scripts need no entry for queries about messages that do not exist
        let function = self.state.function(self.program, slot);
        let provided = answer.or_else(|| self.environment.read(function?, arguments).ok()?);
        self.stack.truncate(first_argument);
        self.record_read(slot);
        let default = MessagesInTransit::default_answer(query, messages);
        let value = match provided {
            Some(value) if value != default => {
                self.record.inputs.push(StepInput {
                    slot,
                    value: value.clone(),
                });
                value
            }
            Some(_) | None => default,
        };
        self.state.store.slots[slot as usize] = value.clone();
        value
    }

    /// Updates the status of agents with message actions: ready for one that received a message,
    /// blocked for one that found none. An update by a rule takes precedence.
    ///
    /// # Errors
    /// [`RuleStopped`] if the status of an agent cannot be written, because the agent is not in the domain of the
    /// status function; the fault is in the context.
    pub fn finish_messages(&mut self) -> Result<(), RuleStopped> {
        let Some(messages) = &self.program.messages else {
            return Ok(());
        };
        let action = std::mem::take(&mut self.record.performed);
        for agent in action.iter().filter_map(|done| done.arguments.first()) {
            self.finish_messages_of(agent, &action, messages)?;
        }
        self.record.performed = action;
        Ok(())
    }

    fn finish_messages_of(
        &mut self,
        agent: &Value,
        done: &[PerformedAction],
        messages: &Messages,
    ) -> Result<(), RuleStopped> {
        let mut own_actions = done
            .iter()
            .filter(|done| done.arguments.first() == Some(agent));
        let has_received = own_actions
            .clone()
            .any(|done| done.action == MessageAction::Take);
        let Some(origin) = own_actions.find_map(|done| match done.action {
            MessageAction::Take | MessageAction::Wait => Some(done.origin),
            MessageAction::Send
            | MessageAction::Call
            | MessageAction::Reply
            | MessageAction::Answer
            | MessageAction::Cancel => None,
        }) else {
            return Ok(());
        };
        self.stack.push(agent.clone());
        let slot = self.slot(messages.status, self.stack.len() - 1);
        self.stack.pop();
        self.checked()?;
        let status = if has_received {
            &messages.ready
        } else {
            &messages.blocked
        };
        if self.updates.written_value(slot).is_some()
            || self.state.store.slots[slot as usize] == *status
        {
            return Ok(());
        }
        let codomain = CodomainCheck::of(self.program, messages.status);
        self.write(slot, status.clone(), codomain, origin)
    }
}
