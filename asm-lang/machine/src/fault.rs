//! Faults: the reasons why a step has no next state.

use crate::misfit::DomainMisfit;
use asmotion_ir::{Origin, Slot};
use asmotion_value::Value;

/// A failed step. The state remains as before the step, except after a violated invariant.
#[derive(Clone, Debug, PartialEq)]
pub struct StepFault {
    /// The reason for the failure.
    pub kind: FaultKind,
    /// The rule or term that failed.
    pub origin: Origin,
    /// The agent that was running, undef if the specification has none.
    pub agent: Value,
    /// The number of the step, from 1; 0 while the initial state is computed.
    pub step: u64,
}

/// The reason for a fault.
#[derive(Clone, Debug, PartialEq)]
pub enum FaultKind {
    /// Inconsistent update set: a location has two updates with different values.
    Clash {
        /// Slot of the location.
        slot: Slot,
        /// Value of the first update.
        first: Value,
        /// Rule of the first update.
        first_origin: Origin,
        /// Value of the second update, whose rule is the fault's origin.
        second: Value,
    },
    /// A rule updates a location to a value outside the codomain.
    Outside {
        /// Slot of the location.
        slot: Slot,
        /// The offending part of the value.
        misfit: DomainMisfit,
    },
    /// The environment provides a value outside the codomain.
    OutsideInput {
        /// Slot of the location.
        slot: Slot,
        /// The offending part of the value.
        misfit: DomainMisfit,
        /// Source of the value, from [`Environment::source`](crate::Environment::source).
        source: String,
    },
    /// A rule updates a location with an argument outside the function's domain.
    OutsideArgument {
        /// Slot of the location.
        slot: Slot,
        /// The offending part of an argument.
        misfit: DomainMisfit,
    },
    /// The guard of a rule is undef.
    UndefinedGuard,
    /// A library function is undefined for its arguments.
    Library(asmotion_stdlib::BuiltinFault),
    /// A variable ranges over an infinite domain.
    Infinite,
    /// A variable ranges over a value that is not a collection.
    NotACollection(Value),
    /// A term run as a rule has another value.
    NotARule(Value),
    /// A rule value is run with the wrong number of arguments.
    RuleArity {
        /// Number of the rule's parameters.
        expected: u32,
        /// Number of arguments given.
        actual: u32,
    },
    /// An agent without a program is run.
    NoProgram(Value),
    /// The nesting of calls exceeds this limit.
    TooDeep(u32),
    /// The number of calls in the step exceeds this limit.
    ManyCalls(u32),
    /// The number of loop iterations in the step exceeds this limit.
    Endless(u32),
    /// An interval or extent has too many elements: this number.
    TooLarge(u64),
    /// A variable is used outside its scope.
    Unbound,
    /// A value of an open domain exceeds the limits for nesting or size.
    Unbounded,
    /// The environment cannot provide a value.
    Input {
        /// Slot of the location.
        slot: Slot,
        /// Error text of the environment.
        reason: String,
    },
    /// An invariant does not hold.
    Invariant {
        /// Index into [`Program::invariants`](asmotion_ir::Program::invariants).
        index: usize,
        /// Value of the condition: false or undef.
        value: Value,
    },
    /// No inputs that a random simulation draws satisfy the constraints (`INVAR`) of the program.
    NoInputs {
        /// Indices of the constraints that did not hold, into [`Program::invariants`](asmotion_ir::Program::invariants).
        constraints: Vec<usize>,
        /// `true` if all values that can be drawn were tried.
        is_exhaustive: bool,
    },
    /// The values picked for a `choose` from outside are not candidates.
    NoCandidate(Vec<Value>),
    /// The program is a module, which has no main rule.
    NoMain,
}
