//! Random inputs that satisfy the constraints (`INVAR`) of a specification: what verification excludes is not drawn.

use crate::random::{CandidateCount, Random};
use asmotion_ir::{FunctionId, Program, ValueShape};
use asmotion_machine::{Environment, FaultKind, Machine, StepFault};
use asmotion_value::Value;
use std::collections::{BTreeMap, BTreeSet};

/// Number of draws before values are tried in order. All combinations that satisfy the constraints are equally likely to be drawn.
const DRAWS: u64 = 100;

/// Number of combinations that are tried in order.
const ATTEMPTS: u64 = 100_000;

/// Values of input locations.
pub type InputValues = BTreeMap<(FunctionId, Vec<Value>), Value>;

/// Given values, and an environment for all other inputs.
pub struct ConstrainedInputs<'a> {
    values: InputValues,
    otherwise: &'a mut dyn Environment,
}

impl<'a> ConstrainedInputs<'a> {
    /// Takes `values` in place of those of the environment `otherwise`.
    pub fn new(values: InputValues, otherwise: &'a mut dyn Environment) -> Self {
        Self { values, otherwise }
    }
}

impl Environment for ConstrainedInputs<'_> {
    fn read(&mut self, function: FunctionId, arguments: &[Value]) -> Result<Option<Value>, String> {
        match self.values.get(&(function, arguments.to_vec())) {
            Some(value) => Ok(Some(value.clone())),
            None => self.otherwise.read(function, arguments),
        }
    }

    fn source(&self, function: FunctionId, arguments: &[Value]) -> String {
        self.otherwise.source(function, arguments)
    }
}

impl Random {
    /// Draws the inputs that the constraints of the program read, such that the constraints hold in the machine's next step, at
    /// the time `now_ns` in nanoseconds. Inputs in `given` are not drawn. Without constraints that read inputs nothing is drawn.
    ///
    /// # Errors
    /// No values were found: [`FaultKind::NoInputs`], or the fault with which the evaluation of a constraint fails. The machine's
    /// last step is then a failed one.
    pub fn constrained_inputs(
        &mut self,
        machine: &mut Machine,
        given: &InputValues,
        now_ns: i64,
    ) -> Result<InputValues, Box<StepFault>> {
        let program = machine.program().clone();
        if !program.invariants.iter().any(|it| it.is_constraint) {
            return Ok(InputValues::new());
        }
        let mut search = ConstraintSearch {
            random: self,
            program: &program,
            given,
            decisions: Vec::new(),
            is_ordered: false,
            is_exhaustive: true,
            violated: BTreeSet::new(),
        };
        if search.finds(machine, now_ns) {
            return Ok(search.values());
        }
        // the machine records the inputs of the failed step
        search.restart(false);
        match machine.check_constraints(&mut search, now_ns) {
            Ok(()) => Ok(search.values()),
            Err(fault) => Err(search.failed(fault)),
        }
    }
}

/// Searches values of inputs for which all constraints hold.
struct ConstraintSearch<'a> {
    random: &'a mut Random,
    program: &'a Program,
    given: &'a InputValues,
    /// Values of the inputs that were read, in order of reading: equal values lead to equal inputs read next.
    decisions: Vec<InputDecision<'a>>,
    /// `true` if values are tried in order, `false` if they are drawn.
    is_ordered: bool,
    /// `true` if all values that can be drawn are tried in order.
    is_exhaustive: bool,
    /// Indices of the constraints that did not hold.
    violated: BTreeSet<usize>,
}

/// The value of an input, and the values that are tried after it.
struct InputDecision<'a> {
    location: (FunctionId, Vec<Value>),
    value: Value,
    rest: Option<OrderedCandidates<'a>>,
}

/// The values of an input from a random one on, in a circle.
struct OrderedCandidates<'a> {
    shape: &'a ValueShape,
    count: u64,
    next: u64,
    /// Number of values that were not tried.
    left: u64,
}

impl<'a> ConstraintSearch<'a> {
    /// Returns whether values were found, first by draws, then in order.
    fn finds(&mut self, machine: &Machine, now_ns: i64) -> bool {
        let mut trial = machine.clone();
        for _ in 0..DRAWS {
            self.restart(false);
            if self.holds(machine, &mut trial, now_ns) {
                return true;
            }
            if self.decisions.is_empty() {
                return false;
            }
        }
        self.restart(true);
        for _ in 0..ATTEMPTS {
            if self.holds(machine, &mut trial, now_ns) {
                return true;
            }
            if !self.advance() {
                return false;
            }
        }
        self.is_exhaustive = false;
        false
    }

    fn restart(&mut self, is_ordered: bool) {
        self.decisions.clear();
        self.is_ordered = is_ordered;
    }

    /// Evaluates the constraints for the decided values and those of inputs read in addition.
    fn holds(&mut self, machine: &Machine, trial: &mut Machine, now_ns: i64) -> bool {
        if machine.steps() == 0 {
            // the inputs of the first step can be part of the initial state
            trial.clone_from(machine);
        }
        match trial.check_constraints(self, now_ns) {
            Ok(()) => true,
            Err(fault) => {
                self.note(&fault);
                false
            }
        }
    }

    fn note(&mut self, fault: &StepFault) {
        if let FaultKind::Invariant { index, .. } = fault.kind {
            self.violated.insert(index);
        }
    }

    /// Takes the next combination of values; returns `false` if there is none.
    fn advance(&mut self) -> bool {
        while let Some(last) = self.decisions.last_mut() {
            let next = last.rest.as_mut().and_then(OrderedCandidates::next);
            if let (Some(index), Some(rest)) = (next, &last.rest) {
                last.value = self.random.candidate(rest.shape, index);
                return true;
            }
            self.decisions.pop();
        }
        false
    }

    fn decide(&mut self, shape: &'a ValueShape) -> (Value, Option<OrderedCandidates<'a>>) {
        if !self.is_ordered {
            return (self.random.value(shape), None);
        }
        let CandidateCount::Finite(count) = self.random.candidates(shape) else {
            self.is_exhaustive = false;
            return (self.random.value(shape), None);
        };
        let mut rest = OrderedCandidates {
            shape,
            count,
            next: self.random.below(count),
            left: count,
        };
        match rest.next() {
            Some(index) => (self.random.candidate(shape, index), Some(rest)),
            None => (Value::Undef, None),
        }
    }

    fn values(self) -> InputValues {
        let decisions = self.decisions.into_iter();
        decisions.map(|it| (it.location, it.value)).collect()
    }

    /// Returns the fault of a step without inputs that satisfy the constraints.
    fn failed(mut self, mut fault: Box<StepFault>) -> Box<StepFault> {
        self.note(&fault);
        let is_given = self.decisions.is_empty() && !self.given.is_empty();
        if matches!(fault.kind, FaultKind::Invariant { .. }) && !is_given {
            fault.kind = FaultKind::NoInputs {
                constraints: self.violated.into_iter().collect(),
                is_exhaustive: self.is_exhaustive,
            };
        }
        fault
    }
}

impl OrderedCandidates<'_> {
    /// Returns the index of the next value.
    fn next(&mut self) -> Option<u64> {
        self.left = self.left.checked_sub(1)?;
        let index = self.next;
        self.next = (self.next + 1) % self.count;
        Some(index)
    }
}

impl Environment for ConstraintSearch<'_> {
    fn read(&mut self, function: FunctionId, arguments: &[Value]) -> Result<Option<Value>, String> {
        let location = (function, arguments.to_vec());
        if let Some(value) = self.given.get(&location) {
            return Ok(Some(value.clone()));
        }
        let mut decided = self.decisions.iter();
        if let Some(decision) = decided.find(|it| it.location == location) {
            return Ok(Some(decision.value.clone()));
        }
        if !self.random.is_drawn(function) {
            return Ok(None);
        }
        let (value, rest) = self.decide(&self.program.functions[function.0 as usize].codomain);
        self.decisions.push(InputDecision {
            location,
            value: value.clone(),
            rest,
        });
        Ok(Some(value))
    }
}
