//! Simulated partners: services that are absent, with scripted replies.

use asmotion_machine::{CallFault, Machine, MessageId, SentKind};
use asmotion_value::Value;

/// A scripted reply to an operation.
#[derive(Clone, Debug, PartialEq)]
pub struct ScriptedAnswer {
    /// The agent that represents the partner.
    pub partner: Value,
    /// Name of the operation.
    pub operation: String,
    /// The reply, or a fault. A fault ends a call; a one-way message gets no reply.
    pub outcome: Result<Value, CallFault>,
    /// Number of steps between request and reply; 1 is the step after the request.
    pub after: u64,
}

/// The simulated partners of a run, and their pending replies.
#[derive(Clone, Debug, Default)]
pub(crate) struct ScriptedPartners {
    answers: Vec<ScriptedAnswer>,
    due: Vec<DueAnswer>,
}

#[derive(Clone, Debug)]
struct DueAnswer {
    step: u64,
    /// Index into the list of scripted replies.
    answer: usize,
    request: MessageId,
    by: Value,
    /// `true` if the request is a call, `false` if it is a one-way message.
    waits: bool,
}

impl ScriptedPartners {
    /// Creates the partners. From now on, messages to them leave the machine.
    pub fn new(answers: Vec<ScriptedAnswer>, machine: &mut Machine) -> Self {
        let partners = answers.iter().map(|answer| answer.partner.clone());
        machine.set_partners(partners.collect());
        Self {
            answers,
            due: Vec::new(),
        }
    }

    /// Delivers the replies that are due in the next step.
    pub fn deliver_replies(&mut self, machine: &mut Machine) {
        let step = machine.steps() + 1;
        for due in self.due.extract_if(.., |due| due.step <= step) {
            let answer = &self.answers[due.answer];
            match &answer.outcome {
                outcome if due.waits => machine.end_call(due.request, outcome.clone()),
                Ok(data) => {
                    let (from, data) = (answer.partner.clone(), data.clone());
                    machine.deliver(from, due.by, &answer.operation, data);
                }
                Err(_) => machine.set_unsent(due.by, &answer.operation),
            }
        }
    }

    /// Schedules the replies to the messages sent in the last step.
    pub fn schedule_replies(&mut self, machine: &Machine) {
        for sent in machine.last_step().sent() {
            let waits = match sent.kind {
                SentKind::Call { .. } => true,
                SentKind::Message { .. } => false,
                SentKind::Cancel { call } => {
                    self.due.retain(|due| due.request != call);
                    continue;
                }
                SentKind::Reply { .. } => continue,
            };
            let Value::Text(operation) = &sent.operation else {
                continue;
            };
            let operation = asmotion_stdlib::operation(operation);
            let mut answers = self.answers.iter();
            let answer = answers
                .position(|answer| answer.partner == sent.to && answer.operation == operation);
            if let Some(answer) = answer {
                self.due.push(DueAnswer {
                    step: machine.steps() + self.answers[answer].after,
                    answer,
                    request: sent.id,
                    by: sent.from.clone(),
                    waits,
                });
            }
        }
    }
}
