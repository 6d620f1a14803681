//! Partners that a script plays: services that are not there, and what they answer.

use asmotion_machine::{CallFault, Machine, MessageId, SentKind};
use asmotion_value::Value;

/// What a partner answers to an operation.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct ScriptedAnswer {
    /// The agent that stands for the partner.
    pub partner: Value,
    /// The operation.
    pub operation: String,
    /// What it answers; a fault ends a call, and answers a message with nothing.
    pub outcome: Result<Value, CallFault>,
    /// In which step after the one that asked; 1 is the next one.
    pub after: u64,
}

/// The partners of a run, and the answers that are due.
#[derive(Clone, Debug, Default)]
pub(crate) struct ScriptedPartners {
    answers: Vec<ScriptedAnswer>,
    due: Vec<DueAnswer>,
}

#[derive(Clone, Debug)]
struct DueAnswer {
    step: u64,
    /// Its place among the answers.
    answer: usize,
    asked: MessageId,
    by: Value,
    /// Whether the asker waits for the reply, or receives it as a message.
    waits: bool,
}

impl ScriptedPartners {
    /// Partners with these answers; their messages leave the machine from now on.
    pub fn new(answers: Vec<ScriptedAnswer>, machine: &mut Machine) -> Self {
        let partners = answers.iter().map(|answer| answer.partner.clone());
        machine.set_partners(partners.collect());
        Self {
            answers,
            due: Vec::new(),
        }
    }

    /// Brings the answers that are due in the next step.
    pub fn answer(&mut self, machine: &mut Machine) {
        let step = machine.steps() + 1;
        for due in self.due.extract_if(.., |due| due.step <= step) {
            let answer = &self.answers[due.answer];
            match &answer.outcome {
                outcome if due.waits => machine.end_call(due.asked, outcome.clone()),
                Ok(data) => {
                    let (from, data) = (answer.partner.clone(), data.clone());
                    machine.deliver(from, due.by, &answer.operation, data);
                }
                Err(_) => machine.set_unsent(due.by, &answer.operation),
            }
        }
    }

    /// Hears what the last step sent.
    pub fn hear(&mut self, machine: &Machine) {
        for sent in machine.last_step().sent() {
            let waits = match sent.kind {
                SentKind::Call { .. } => true,
                SentKind::Message { .. } => false,
                SentKind::Cancel { call } => {
                    self.due.retain(|due| due.asked != call);
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
                    asked: sent.id,
                    by: sent.from.clone(),
                    waits,
                });
            }
        }
    }
}
