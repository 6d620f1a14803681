//! Outcome of a scenario.

use crate::codes::v020::CheckFailed;
use crate::codes::v021::ScenarioInvariantFailed;
use crate::codes::v022::UntilDidNotEnd;
use crate::failed_condition::FailedCondition;
use asmotion_diagnostics::{Diagnostic, Finding, Span};
use asmotion_machine::{FaultKind, StepFault};

/// The verdict on a scenario.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Verdict {
    /// All checks and invariants hold.
    Pass,
    /// A check failed, a `step until` reached its limit, or a picked value is not a candidate.
    Fail,
    /// An invariant was violated.
    Invariant,
    /// A step, check or command ended with a fault.
    Fault,
}

impl Verdict {
    /// Returns the verdict for a fault.
    pub(super) fn of(fault: &StepFault) -> Self {
        match fault.kind {
            FaultKind::Invariant { .. } | FaultKind::NoInputs { .. } => Self::Invariant,
            FaultKind::NoCandidate(_) => Self::Fail,
            FaultKind::Clash { .. }
            | FaultKind::Outside { .. }
            | FaultKind::OutsideInput { .. }
            | FaultKind::OutsideArgument { .. }
            | FaultKind::UndefinedGuard
            | FaultKind::Library(_)
            | FaultKind::Infinite
            | FaultKind::NotACollection(_)
            | FaultKind::NotARule(_)
            | FaultKind::RuleArity { .. }
            | FaultKind::NoProgram(_)
            | FaultKind::TooDeep(_)
            | FaultKind::ManyCalls(_)
            | FaultKind::Endless(_)
            | FaultKind::TooLarge(_)
            | FaultKind::Unbound
            | FaultKind::Unbounded
            | FaultKind::Input { .. }
            | FaultKind::NoMain => Self::Fault,
        }
    }

    /// Returns the word shown for the verdict.
    pub fn word(self) -> &'static str {
        match self {
            Self::Pass => "pass",
            Self::Fail => "fail",
            Self::Invariant => "invariant",
            Self::Fault => "fault",
        }
    }
}

/// The result of running a scenario.
#[derive(Clone, Debug)]
pub struct ScenarioOutcome {
    /// Determined by the first failure.
    pub verdict: Verdict,
    /// Number of steps executed.
    pub steps: u64,
    /// Number of checks that hold.
    pub checks: u64,
    /// All failures, in order; empty if the scenario passed.
    pub failures: Vec<ScenarioFailure>,
}

impl ScenarioOutcome {
    /// Returns the outcome for a machine whose initial state has a fault. `at` is the span in the
    /// scenario that names the specification.
    pub fn initial_fault(fault: Box<StepFault>, at: Span) -> Self {
        Self {
            verdict: Verdict::of(&fault),
            steps: 0,
            checks: 0,
            failures: vec![ScenarioFailure {
                at,
                steps: 0,
                kind: ScenarioFailureKind::Fault(fault),
            }],
        }
    }
}

/// A failure of a scenario.
#[derive(Clone, Debug)]
pub struct ScenarioFailure {
    /// Span of the command in the scenario.
    pub at: Span,
    /// Number of steps executed before it.
    pub steps: u64,
    /// Kind of the failure, with the observed values.
    pub kind: ScenarioFailureKind,
}

/// The kind of a failure.
#[derive(Clone, Debug)]
pub enum ScenarioFailureKind {
    /// A check does not hold.
    Check(FailedCondition),
    /// An invariant of the scenario, with its name, does not hold.
    Invariant(String, FailedCondition),
    /// `step until` reached its limit, the given number of steps.
    Until(u64, FailedCondition),
    /// A step or command ended with a fault.
    Fault(Box<StepFault>),
}

impl ScenarioFailure {
    /// Returns the diagnostic. `None` for a fault, which is explained by the specification.
    pub fn diagnostic(&self) -> Option<Diagnostic> {
        let steps = self.steps;
        match &self.kind {
            ScenarioFailureKind::Check(seen) => Some(CheckFailed { seen, steps }.diagnostic()),
            ScenarioFailureKind::Invariant(name, seen) => {
                let at = self.at;
                Some(
                    ScenarioInvariantFailed {
                        name,
                        seen,
                        steps,
                        at,
                    }
                    .diagnostic(),
                )
            }
            ScenarioFailureKind::Until(limit, seen) => {
                let limit = *limit;
                Some(UntilDidNotEnd { limit, seen }.diagnostic())
            }
            ScenarioFailureKind::Fault(_) => None,
        }
    }
}
