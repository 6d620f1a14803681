//! What a step read, chose, printed and sent.

use crate::messages::{PerformedAction, SentMessage};
use asmotion_ir::{Origin, Slot};
use asmotion_value::Value;

/// What the environment said about a location in a step.
#[derive(Clone, Debug, PartialEq)]
pub struct StepInput {
    /// The location.
    pub slot: Slot,
    /// Its value for this step.
    pub value: Value,
}

/// What was chosen where.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct StepChoice {
    /// The `choose`.
    pub origin: Origin,
    /// Which candidate, from 0.
    pub index: usize,
    /// How many there were.
    pub count: usize,
}

/// What a step read, chose and printed.
#[derive(Debug, Default)]
pub(crate) struct StepLog {
    pub inputs: Vec<StepInput>,
    pub choices: Vec<StepChoice>,
    /// What was picked from outside, by the place of the variable's range.
    pub picked: Vec<(Origin, Value)>,
    pub printed: Vec<String>,
    /// What agents did with messages.
    pub done: Vec<PerformedAction>,
    /// What was sent.
    pub sent: Vec<SentMessage>,
    pub now_ns: i64,
    /// How often what is counted ran, in all steps.
    pub counts: Vec<u64>,
}

impl StepLog {
    /// Counts once more.
    pub fn count(&mut self, counter: u32) {
        let index = counter as usize;
        if self.counts.len() <= index {
            self.counts.resize(index + 1, 0);
        }
        self.counts[index] += 1;
    }

    /// How often it was counted.
    pub fn counted(&self, counter: u32) -> u64 {
        self.counts.get(counter as usize).copied().unwrap_or(0)
    }

    #[inline]
    pub fn begin(&mut self, now_ns: i64) {
        self.choices.clear();
        // most steps of a fast machine have none of these
        let kept = self.inputs.len()
            | self.picked.len()
            | self.printed.len()
            | self.done.len()
            | self.sent.len();
        if kept > 0 {
            self.inputs.clear();
            self.picked.clear();
            self.printed.clear();
            self.done.clear();
            self.sent.clear();
        }
        self.now_ns = now_ns;
    }
}
