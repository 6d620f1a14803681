//! How a scenario ended, and why.

use crate::codes::v020::CheckFailed;
use crate::codes::v021::ScenarioInvariantFailed;
use crate::codes::v022::UntilDidNotEnd;
use crate::seen::FailedCondition;
use asmotion_diagnostics::{Diagnostic, Finding, Span};
use asmotion_machine::{FaultKind, StepFault};

/// The end of a scenario.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Verdict {
    /// Every check held.
    Pass,
    /// A check did not hold, a `step until` did not end, or a pick was no candidate.
    Fail,
    /// An invariant was violated.
    Invariant,
    /// A step, check or command failed at run time.
    Fault,
}

impl Verdict {
    /// The verdict that a fault is.
    pub(super) fn of(fault: &StepFault) -> Self {
        match fault.kind {
            FaultKind::Invariant { .. } => Self::Invariant,
            FaultKind::NoCandidate(_) => Self::Fail,
            _ => Self::Fault,
        }
    }

    /// The word for it.
    pub fn word(self) -> &'static str {
        match self {
            Self::Pass => "pass",
            Self::Fail => "fail",
            Self::Invariant => "invariant",
            Self::Fault => "fault",
        }
    }
}

/// What came of a scenario.
#[derive(Clone, Debug)]
pub struct ScenarioOutcome {
    /// How it ended.
    pub verdict: Verdict,
    /// How many steps were done.
    pub steps: u64,
    /// How many checks held.
    pub checks: u64,
    /// What went wrong, in order.
    pub failures: Vec<ScenarioFailure>,
}

impl ScenarioOutcome {
    /// The machine could not be built; the place says which specification it is of.
    pub fn unbegun(fault: Box<StepFault>, at: Span) -> Self {
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

/// Something that went wrong.
#[derive(Clone, Debug)]
pub struct ScenarioFailure {
    /// The place in the scenario.
    pub at: Span,
    /// How many steps had been done.
    pub steps: u64,
    /// What it was.
    pub kind: ScenarioFailureKind,
}

/// What may go wrong.
#[derive(Clone, Debug)]
pub enum ScenarioFailureKind {
    /// A check does not hold.
    Check(FailedCondition),
    /// An invariant of the scenario does not hold.
    Invariant(String, FailedCondition),
    /// `step until` did not come to its end.
    Until(u64, FailedCondition),
    /// The machine failed.
    Fault(Box<StepFault>),
}

impl ScenarioFailure {
    /// The failure in words; what a fault says, the specification knows.
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
