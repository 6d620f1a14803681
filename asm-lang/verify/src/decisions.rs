//! The nondeterminism of a step as a sequence of decisions: inputs that it reads and choices that it makes, enumerated by
//! executing the step again with the next sequence.

use crate::inputs::InputRanges;
use asmotion_lang::ir::FunctionId;
use asmotion_lang::{Chooser, Environment, Value};
use std::cell::RefCell;

/// Limit for the executions of the step in a state, and for the combinations of inputs that properties mention.
pub(crate) const MAX_EXECUTIONS: u64 = 1 << 17;

/// The value of an input location.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub(crate) struct InputValue {
    /// Index of the machine that reads it.
    pub machine: usize,
    pub function: FunctionId,
    pub arguments: Box<[Value]>,
    pub value: Value,
}

/// One of several possibilities.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Decision {
    /// Index of the possibility, from 0.
    pub taken: u32,
    /// Number of possibilities, at least 1.
    pub count: u32,
}

/// The decisions of one execution of a step. The last one changes first, so that the sequences of all executions are in
/// lexicographic order.
#[derive(Debug, Default)]
pub(crate) struct Decisions {
    current: RefCell<Sequence>,
}

#[derive(Debug, Default)]
struct Sequence {
    taken: Vec<Decision>,
    /// Number of decisions of the current execution so far.
    at: usize,
    /// Inputs that the current execution has read and that were not known before.
    read: Vec<InputValue>,
    /// Inputs that have only this value.
    fixed: Vec<InputValue>,
}

impl Sequence {
    fn next(&mut self, count: usize) -> usize {
        self.next_from(0, count)
    }

    /// Decides between the possibilities from this one on.
    fn next_from(&mut self, first: usize, count: usize) -> usize {
        let at = self.at;
        self.at += 1;
        if let Some(decision) = self.taken.get(at) {
            return decision.taken as usize;
        }
        self.taken.push(Decision {
            taken: u32::try_from(first).unwrap_or(u32::MAX),
            count: u32::try_from(count).unwrap_or(u32::MAX),
        });
        first
    }
}

impl Decisions {
    /// The sequences in which these inputs have these values.
    #[cfg(feature = "symbolic")]
    pub fn with(fixed: Vec<InputValue>) -> Self {
        let decisions = Self::default();
        decisions.current.borrow_mut().fixed = fixed;
        decisions
    }

    /// Returns to the first sequence.
    pub fn restart(&self) {
        let mut current = self.current.borrow_mut();
        current.taken.clear();
        current.at = 0;
        current.read.clear();
    }

    /// Continues with the next sequence after an execution; returns `false` after the last one.
    pub fn advance(&self) -> bool {
        let mut current = self.current.borrow_mut();
        let at = current.at;
        current.taken.truncate(at);
        current.at = 0;
        current.read.clear();
        while let Some(last) = current.taken.last_mut() {
            if last.taken + 1 < last.count {
                last.taken += 1;
                return true;
            }
            current.taken.pop();
        }
        false
    }

    /// Decides between a number of possibilities; returns the index of one.
    pub fn decide(&self, count: usize) -> usize {
        self.current.borrow_mut().next(count)
    }

    /// Returns `true` if the current execution has read an input.
    pub fn has_read(&self, machine: usize, function: FunctionId, arguments: &[Value]) -> bool {
        let current = self.current.borrow();
        current.read.iter().any(|input| {
            input.machine == machine && input.function == function && *input.arguments == *arguments
        })
    }

    /// Returns the value of an input: the one that the current execution has read, or one of these.
    pub fn input(
        &self,
        machine: usize,
        function: FunctionId,
        arguments: &[Value],
        values: &[Value],
    ) -> Value {
        let mut current = self.current.borrow_mut();
        let is_it = |input: &&InputValue| {
            input.machine == machine && input.function == function && *input.arguments == *arguments
        };
        if let Some(known) = current.read.iter().find(is_it) {
            return known.value.clone();
        }
        let fixed = current.fixed.iter().find(is_it);
        let fixed = fixed.and_then(|fixed| values.iter().position(|it| *it == fixed.value));
        let taken = match fixed {
            Some(index) => current.next_from(index, index + 1),
            None => current.next(values.len()),
        };
        let value = values.get(taken).cloned().unwrap_or_default();
        current.read.push(InputValue {
            machine,
            function,
            arguments: arguments.into(),
            value: value.clone(),
        });
        value
    }

    /// Returns the inputs that the current execution has read, in order of reading.
    pub fn read(&self) -> Vec<InputValue> {
        self.current.borrow().read.clone()
    }

    /// Returns the decisions of the current execution.
    pub fn taken(&self) -> Vec<Decision> {
        let current = self.current.borrow();
        current.taken.iter().take(current.at).copied().collect()
    }

    /// Starts with a sequence that [`Decisions::taken`] returned.
    pub fn repeat(&self, taken: &[Decision]) {
        self.restart();
        self.current.borrow_mut().taken.extend_from_slice(taken);
    }
}

/// The choices of an execution.
pub(crate) struct DecidedChoices<'a>(pub &'a Decisions);

impl Chooser for DecidedChoices<'_> {
    fn choose(&mut self, count: usize) -> usize {
        self.0.current.borrow_mut().next(count)
    }
}

/// The inputs of an execution: those that are known, and one of the possible values for each other one.
pub(crate) struct DecidedInputs<'a> {
    /// Index of the machine that reads them.
    pub machine: usize,
    pub decisions: &'a Decisions,
    pub ranges: &'a InputRanges,
    pub known: &'a [InputValue],
}

impl Environment for DecidedInputs<'_> {
    fn read(&mut self, function: FunctionId, arguments: &[Value]) -> Result<Option<Value>, String> {
        let is_it = |input: &&InputValue| {
            input.machine == self.machine
                && input.function == function
                && *input.arguments == *arguments
        };
        if let Some(known) = self.known.iter().find(is_it) {
            return Ok(Some(known.value.clone()));
        }
        let values = self.ranges.of(function)?;
        let value = self
            .decisions
            .input(self.machine, function, arguments, values);
        Ok(Some(value))
    }

    fn source(&self, _function: FunctionId, _arguments: &[Value]) -> String {
        "the verifier".to_owned()
    }
}
