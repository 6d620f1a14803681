//! Transition systems: what an exploration executes, whether it is one machine or several with their environment.

use crate::codes::m011::MailboxOverflow;
use crate::codes::main_rule;
use crate::decisions::{DecidedChoices, DecidedInputs, Decisions, InputValue};
use crate::inputs::{InputRanges, NOT_ENUMERATED};
use asmotion_diagnostics::{Diagnostic, Finding};
use asmotion_lang::hir::AddedTerm;
use asmotion_lang::{FaultKind, Machine, Specification, StepFault, Value};

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
    pub cause: FaultCause,
}

/// The reason for which a step fails.
#[derive(Debug)]
pub(crate) enum FaultCause {
    /// The machine has no next state.
    Step(Box<StepFault>),
    /// A message that the step sent does not fit into a mailbox.
    Mailbox(Box<FullMailbox>),
}

/// A message that does not fit into a mailbox.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct FullMailbox {
    /// Names of the machines.
    pub sender: String,
    pub receiver: String,
    pub operation: String,
    /// Number of messages that fit.
    pub bound: usize,
}

impl MachineFault {
    /// A fault of a machine's step.
    pub fn of_step(machine: usize, fault: Box<StepFault>) -> Self {
        Self {
            machine,
            cause: FaultCause::Step(fault),
        }
    }

    /// Returns the fault of the machine's step, if it is one.
    pub fn step(&self) -> Option<&StepFault> {
        match &self.cause {
            FaultCause::Step(fault) => Some(fault),
            FaultCause::Mailbox(_) => None,
        }
    }

    /// Returns `true` if the reason is an input without a value.
    pub fn is_of_input(&self) -> bool {
        let step = self.step();
        step.is_some_and(|fault| matches!(fault.kind, FaultKind::Input { .. }))
    }

    /// Returns `true` if the reason is an input whose values cannot be enumerated.
    pub fn is_of_unbounded_input(&self) -> bool {
        let step = self.step();
        step.is_some_and(|fault| {
            matches!(&fault.kind, FaultKind::Input { reason, .. } if reason == NOT_ENUMERATED)
        })
    }

    /// Returns `true` if another fault has the same reason at the same place.
    pub fn is_like(&self, other: &Self) -> bool {
        let is_like = match (&self.cause, &other.cause) {
            (FaultCause::Step(own), FaultCause::Step(other)) => {
                own.origin == other.origin
                    && std::mem::discriminant(&own.kind) == std::mem::discriminant(&other.kind)
            }
            (FaultCause::Mailbox(own), FaultCause::Mailbox(other)) => own == other,
            (FaultCause::Step(_), FaultCause::Mailbox(_))
            | (FaultCause::Mailbox(_), FaultCause::Step(_)) => false,
        };
        self.machine == other.machine && is_like
    }

    /// Describes the fault; `machine` is in the state in which it occurred, if it is known.
    pub fn diagnostic(
        &self,
        specification: &Specification,
        machine: Option<&Machine>,
    ) -> Diagnostic {
        match (&self.cause, machine) {
            (FaultCause::Step(fault), Some(machine)) => specification.explain_in(fault, machine),
            (FaultCause::Step(fault), None) => specification.explain(fault),
            (FaultCause::Mailbox(full), _) => MailboxOverflow {
                receiver: full.receiver.clone(),
                sender: full.sender.clone(),
                operation: full.operation.clone(),
                bound: full.bound,
                at: main_rule(specification),
            }
            .diagnostic(),
        }
    }
}

/// A set of labels of transitions.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct FairLabels {
    /// The bits of a label that matter, and their values.
    pub mask: u32,
    pub value: u32,
}

impl FairLabels {
    pub fn contains(self, label: u32) -> bool {
        label & self.mask == self.value
    }
}

/// A system with states and nondeterministic steps. All nondeterminism is in the decisions: equal decisions in equal states give equal
/// steps.
pub(crate) trait TransitionSystem: Clone + Send {
    /// Enters an initial state, from the state before any step.
    ///
    /// # Errors
    /// A step of the environment, which precedes the first one of the system, fails.
    fn begin(&mut self, _decisions: &Decisions) -> Result<(), MachineFault> {
        Ok(())
    }

    /// Returns `true` if runs end in the current state.
    fn has_ended(&self) -> bool {
        false
    }

    /// Appends the bytes of the current state, equal for states with the same future.
    fn pack(&mut self, to: &mut Vec<u8>);

    /// Returns to a state given by its bytes, which are from this system.
    fn restore(&mut self, state: &[u8]);

    /// Returns `true` if [`TransitionSystem::revert`] can reverse the next step.
    fn can_revert(&self) -> bool;

    /// Reverses the last step, successful or failed.
    fn revert(&mut self);

    /// Returns `true` if a part of the state belongs to the environment, and can change for ever while nothing else does.
    fn has_surroundings(&self) -> bool {
        false
    }

    /// Appends the bytes of the current state without the part of the environment. The state has been packed or restored before.
    fn pack_own(&self, _to: &mut Vec<u8>) {}

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

    /// Returns `true` if a step of the machine is the first part of the next transition rather than the last one of its own.
    fn prepares_next(&self, _machine: usize) -> bool {
        false
    }

    /// Describes what happened to messages in the last step.
    fn events(&self) -> &[String] {
        &[]
    }

    /// Returns the label of the last step, which fairness refers to.
    fn label(&self) -> u32 {
        0
    }

    /// Returns the transitions that every run takes again and again.
    fn fairness(&self) -> Vec<FairLabels> {
        Vec::new()
    }
    /// Keeps the candidates that `choose` rules take, in the records of future steps.
    fn keep_candidates(&mut self);

    /// Returns the machine and the values of its inputs, if the system is one machine whose inputs have any of these values.
    fn single(&self) -> Option<(&Machine, &InputRanges)> {
        None
    }

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
            Err(fault) => Err(MachineFault::of_step(0, fault)),
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
        done.map_err(|(_, fault)| MachineFault::of_step(0, fault))
    }

    fn machines(&self) -> &[Machine] {
        std::slice::from_ref(&self.machine)
    }

    fn moved(&self) -> &[usize] {
        &[0]
    }

    fn keep_candidates(&mut self) {
        self.machine.keep_candidates();
    }

    fn single(&self) -> Option<(&Machine, &InputRanges)> {
        Some((&self.machine, self.ranges))
    }
}
