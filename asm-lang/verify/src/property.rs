//! Properties and the results of checking them.

use crate::counterexample::Run;
use crate::explore::Incomplete;
use asmotion_diagnostics::Span;
use asmotion_lang::Diagnostic;

/// A property with its verdict.
#[derive(Clone, Debug)]
pub struct CheckedProperty {
    /// Kind of the property.
    pub kind: PropertyKind,
    /// Index of the machine whose specification contains the property, in
    /// [`Verification::machines`](crate::Verification::machines).
    pub machine: usize,
    /// Declared name, if it has one.
    pub name: Option<String>,
    /// Text of the formula, on one line; a description for the kinds without one.
    pub text: String,
    /// Place of the property; `None` if it is not in a file of the specification.
    pub place: Option<Span>,
    /// Result of the check.
    pub verdict: Verdict,
    /// Remarks on how far the verdict can be relied on.
    pub notes: Vec<Note>,
}

impl CheckedProperty {
    /// Returns `true` if the verdict says something about all states, so that no run can show it.
    pub fn is_about_all_states(&self) -> bool {
        match &self.verdict {
            Verdict::Holds(None) | Verdict::Violated(None) => true,
            // of other formulas, a witness is one among many paths
            Verdict::Holds(Some(_)) => self.kind != PropertyKind::Possible,
            Verdict::Violated(Some(_)) | Verdict::Unknown => false,
        }
    }
}

/// The kind of a property.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum PropertyKind {
    /// `invariant`: holds in every state.
    Invariant,
    /// `INVAR` that is checked like an invariant: see
    /// [`Options::checked_constraints`](crate::Options::checked_constraints).
    Constraint,
    /// `CTLSPEC`
    Ctl,
    /// `LTLSPEC`
    Ltl,
    /// A state with this property can be reached.
    Possible,
    /// No step fails: no inconsistent update, no value outside a domain, no undefined guard.
    NoFault,
    /// No state from which nothing can change any more.
    NotStuck,
    /// Every rule is executed in some step.
    RulesRun,
}

/// The result of checking a property.
#[derive(Clone, Debug)]
pub enum Verdict {
    /// It holds; for a possibility, with a run that shows it.
    Holds(Option<Box<Run>>),
    /// It is violated; with a run that shows it, if one run can.
    Violated(Option<Box<Run>>),
    /// Not known, because not all states were explored, or a limit was reached before it was decided.
    Unknown,
}

impl Verdict {
    /// Returns `true` if the property holds.
    pub fn holds(&self) -> bool {
        matches!(self, Self::Holds(_))
    }

    /// Returns `true` if the property is violated.
    pub fn is_violated(&self) -> bool {
        matches!(self, Self::Violated(_))
    }

    /// Returns the run that shows the verdict.
    pub fn run(&self) -> Option<&Run> {
        match self {
            Self::Holds(run) | Self::Violated(run) => run.as_deref(),
            Self::Unknown => None,
        }
    }
}

/// A remark on a verdict.
#[derive(Clone, Debug)]
pub enum Note {
    /// A condition of the property is undef in this number of cases, where it counts as false.
    Undefined(u64),
    /// The evaluation of a condition fails, where it counts as false.
    Fails(Box<Diagnostic>),
    /// The antecedents of these implications are never true: nothing is said about their consequents.
    Unmet(Vec<String>),
    /// The property holds whatever the values of these conditions are.
    Irrelevant(Vec<String>),
    /// From some initial states, no run satisfies the fairness constraints.
    Unfair {
        /// `true` if this is so from all initial states, in which case every property holds.
        all: bool,
    },
    /// Further places where it is violated.
    Also(Vec<String>),
    /// It was not decided, although all states were explored: a limit was reached.
    Undecided(Incomplete),
    /// It holds, but a limit was reached before it was known whether the values of some conditions do not matter.
    Unexamined(Incomplete),
    /// Some steps fail. They have no next state, which can be the reason for the violation.
    FailingSteps,
}
