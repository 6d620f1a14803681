//! The log of a step: inputs, choices, printed texts and messages.

use crate::choose::Chooser;
use crate::messages::{PerformedAction, SentMessage};
use asmotion_ir::{Origin, Slot};
use asmotion_value::Value;

/// The value of a location that the environment provided in a step.
#[derive(Clone, Debug, PartialEq)]
pub struct StepInput {
    /// Slot of the location.
    pub slot: Slot,
    /// Its value during this step.
    pub value: Value,
}

/// A choice made in a step.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct StepChoice {
    /// Place of the `choose` rule or `chooseone` term.
    pub origin: Origin,
    /// Index of the chosen candidate, from 0.
    pub index: usize,
    /// Number of candidates, at least 1.
    pub count: usize,
}

/// The candidate that a `choose` rule took in a step.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct TakenCandidate {
    /// Index of the choice among those of the step, from 0; `None` if the choice was not recorded, because there was only
    /// one way to make it.
    pub choice: Option<usize>,
    /// Place of the `choose` rule.
    pub origin: Origin,
    /// Values of the variables, in the order of their declaration.
    pub values: Vec<Value>,
}

/// The log of the current step, and the coverage counts of all steps.
#[derive(Debug, Default)]
pub(crate) struct StepLog {
    pub inputs: Vec<StepInput>,
    pub choices: Vec<StepChoice>,
    /// `true` to keep the chosen candidates.
    pub keeps_candidates: bool,
    /// The chosen candidates of `choose` rules, if they are kept, in order of choosing.
    pub candidates: Vec<TakenCandidate>,
    /// Values picked from outside, with the place of the variable's range.
    pub picked: Vec<(Origin, Value)>,
    pub printed: Vec<String>,
    /// Actions on messages, performed at the end of the step.
    pub performed: Vec<PerformedAction>,
    /// Messages sent by these actions.
    pub sent: Vec<SentMessage>,
    pub now_ns: i64,
    /// Coverage counts, indexed by counter; not reset between steps.
    pub counts: Vec<u64>,
}

/// The sizes of a log's lists.
pub(crate) struct LogSizes {
    inputs: usize,
    choices: usize,
    picked: usize,
    printed: usize,
}

impl StepLog {
    /// Returns the sizes of the lists to which the evaluation of a term appends.
    pub fn sizes(&self) -> LogSizes {
        LogSizes {
            inputs: self.inputs.len(),
            choices: self.choices.len(),
            picked: self.picked.len(),
            printed: self.printed.len(),
        }
    }

    /// Removes what was appended since the lists had these sizes.
    pub fn shrink(&mut self, sizes: &LogSizes) {
        self.inputs.truncate(sizes.inputs);
        self.choices.truncate(sizes.choices);
        self.picked.truncate(sizes.picked);
        self.printed.truncate(sizes.printed);
    }

    /// Asks a chooser for the index of one of `count` candidates, at least 1, and records the choice.
    #[inline]
    pub fn choose(&mut self, chooser: &mut dyn Chooser, count: usize, origin: Origin) -> usize {
        let index = chooser.choose(count).min(count.saturating_sub(1));
        self.choices.push(StepChoice {
            origin,
            index,
            count,
        });
        index
    }

    /// Increments a coverage counter.
    pub fn count(&mut self, counter: u32) {
        let index = counter as usize;
        if self.counts.len() <= index {
            self.counts.resize(index + 1, 0);
        }
        self.counts[index] += 1;
    }

    /// Allocates the coverage counters.
    #[inline]
    pub fn allocate_counts(&mut self, count: usize) {
        if self.counts.len() < count {
            self.counts.resize(count, 0);
        }
    }

    /// Returns the value of a coverage counter.
    pub fn counted(&self, counter: u32) -> u64 {
        self.counts.get(counter as usize).copied().unwrap_or(0)
    }

    #[inline]
    pub fn begin(&mut self, now_ns: i64) {
        self.choices.clear();
        self.candidates.clear();
        // one test for all: most steps of a fast machine have none of these
        let kept = self.inputs.len()
            | self.picked.len()
            | self.printed.len()
            | self.performed.len()
            | self.sent.len();
        if kept > 0 {
            self.inputs.clear();
            self.picked.clear();
            self.printed.clear();
            self.performed.clear();
            self.sent.clear();
        }
        self.now_ns = now_ns;
    }
}
