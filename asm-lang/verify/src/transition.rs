//! Transition systems: what an exploration executes, whether it is one machine or several with their environment.

use crate::decisions::{DecidedChoices, DecidedInputs, Decisions, InputValue};
use crate::inputs::InputRanges;
use asmotion_lang::hir::AddedTerm;
use asmotion_lang::{Machine, StepFault, Value};

/// A condition that is evaluated in each state.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ConditionTerm {
    /// Index of the machine in whose program the term is.
    pub machine: usize,
    pub term: AddedTerm,
}

/// A fault of a step or of the evaluation of a condition.
#[derive(Debug)]
pub(crate) struct MachineFault {
    /// Index of the machine that failed.
    pub machine: usize,
    pub fault: Box<StepFault>,
}

/// A system with states and nondeterministic steps. All nondeterminism is in the decisions: equal decisions in equal states give equal
/// steps.
pub(crate) trait TransitionSystem: Clone + Send {
    /// Appends the bytes of the current state, equal for states with the same future.
    fn pack(&mut self, to: &mut Vec<u8>);

    /// Returns to a state given by its bytes, which are from this system.
    fn restore(&mut self, state: &[u8]);

    /// Returns `true` if [`TransitionSystem::revert`] can reverse the next step.
    fn can_revert(&self) -> bool;

    /// Reverses the last step, successful or failed.
    fn revert(&mut self);

    /// Executes a step; returns `true` if it updates a location. The inputs in `known` are given, others are decided.
    ///
    /// # Errors
    /// A machine has no next state. The state is then that before the step, or one from which only
    /// [`TransitionSystem::restore`] leads back.
    fn step(&mut self, decisions: &Decisions, known: &[InputValue]) -> Result<bool, MachineFault>;

    /// Evaluates conditions in the current state and appends their values, up to one whose evaluation fails.
    ///
    /// # Errors
    /// The evaluation of the condition after the appended ones fails.
    fn evaluate(
        &mut self,
        conditions: &[ConditionTerm],
        decisions: &Decisions,
        values: &mut Vec<Value>,
    ) -> Result<(), MachineFault>;

    /// Returns the machines.
    fn machines(&self) -> &[Machine];

    /// Returns the indices of the machines that the last step moved, in order.
    fn moved(&self) -> &[usize];

    /// Returns the coverage counts of each machine.
    fn counts(&self) -> Vec<Vec<u64>> {
        self.machines().iter().map(Machine::counts).collect()
    }
}

/// One machine whose inputs have any of their values in each step.
#[derive(Clone)]
pub(crate) struct SingleMachine<'a> {
    pub machine: Machine,
    pub ranges: &'a InputRanges,
}

impl TransitionSystem for SingleMachine<'_> {
    fn pack(&mut self, to: &mut Vec<u8>) {
        self.machine.pack_state(to);
    }

    fn restore(&mut self, state: &[u8]) {
        // cannot fail: the bytes are from a machine with this program
        let _ = self.machine.restore_state(state);
    }

    fn can_revert(&self) -> bool {
        self.machine.can_revert()
    }

    fn revert(&mut self) {
        self.machine.revert();
    }

    fn step(&mut self, decisions: &Decisions, known: &[InputValue]) -> Result<bool, MachineFault> {
        let mut inputs = DecidedInputs {
            machine: 0,
            decisions,
            ranges: self.ranges,
            known,
        };
        let mut choices = DecidedChoices(decisions);
        match self.machine.step(&mut inputs, &mut choices, 0) {
            Ok(step) => Ok(!step.updates().is_empty()),
            Err(fault) => Err(MachineFault { machine: 0, fault }),
        }
    }

    fn evaluate(
        &mut self,
        conditions: &[ConditionTerm],
        decisions: &Decisions,
        values: &mut Vec<Value>,
    ) -> Result<(), MachineFault> {
        let terms: Vec<AddedTerm> = conditions.iter().map(|it| it.term).collect();
        let mut inputs = DecidedInputs {
            machine: 0,
            decisions,
            ranges: self.ranges,
            known: &[],
        };
        let done = self.machine.evaluate_each(&terms, &mut inputs, 0, values);
        done.map_err(|(index, fault)| MachineFault {
            machine: conditions.get(index).map_or(0, |it| it.machine),
            fault,
        })
    }

    fn machines(&self) -> &[Machine] {
        std::slice::from_ref(&self.machine)
    }

    fn moved(&self) -> &[usize] {
        &[0]
    }
}
