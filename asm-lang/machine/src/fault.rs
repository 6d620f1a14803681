//! Why a step has no next state.

use crate::misfit::DomainMisfit;
use asmotion_ir::{Origin, Slot};
use asmotion_value::Value;

/// A step failed. The state is as it was before, but for a violated invariant.
#[derive(Clone, Debug, PartialEq)]
pub struct StepFault {
    /// What happened.
    pub kind: FaultKind,
    /// Where.
    pub origin: Origin,
    /// The agent that ran, or undef.
    pub agent: Value,
    /// The step, counted from 1; 0 while the initial state is built.
    pub step: u64,
}

/// What can happen.
#[derive(Clone, Debug, PartialEq)]
pub enum FaultKind {
    /// A location is given two values at once: the update set is inconsistent.
    Clash {
        /// The location.
        slot: Slot,
        /// The value given first.
        first: Value,
        /// Who gave it.
        first_origin: Origin,
        /// The other value; the fault's origin gave it.
        second: Value,
    },
    /// A value written is not an element of the codomain.
    Outside {
        /// The location.
        slot: Slot,
        /// What does not fit.
        misfit: DomainMisfit,
    },
    /// A value that the environment gave is not an element of the codomain.
    OutsideInput {
        /// The location.
        slot: Slot,
        /// What does not fit.
        misfit: DomainMisfit,
        /// Who gave it.
        source: String,
    },
    /// An argument of a location that is written is not an element of the function's domain.
    OutsideArgument {
        /// The location.
        slot: Slot,
        /// What does not fit.
        misfit: DomainMisfit,
    },
    /// A guard is neither true nor false.
    UndefinedGuard,
    /// A function of the library has no value for these arguments.
    Library(asmotion_stdlib::BuiltinFault),
    /// A variable ranges over a domain without end.
    Infinite,
    /// A variable ranges over a value that is no collection.
    NotACollection(Value),
    /// A value is run that is no rule.
    NotARule(Value),
    /// A rule is run with the wrong number of arguments.
    RuleArity {
        /// How many it takes.
        wanted: u32,
        /// How many it was given.
        actual: u32,
    },
    /// An agent has no program.
    NoProgram(Value),
    /// Calls nest too deeply.
    TooDeep(u32),
    /// One step calls functions and rules too often.
    ManyCalls(u32),
    /// A loop does not end.
    Endless(u32),
    /// An interval or extent has too many elements.
    TooLarge(u64),
    /// A variable is not bound where it stands.
    Unbound,
    /// A value of an open domain nests too deeply, or holds too much.
    Unbounded,
    /// The environment has no answer.
    Input {
        /// The location.
        slot: Slot,
        /// What the environment said.
        reason: String,
    },
    /// An invariant does not hold.
    Invariant {
        /// Its number in the program.
        index: usize,
        /// Its value: false or undef.
        value: Value,
    },
    /// The values picked for a `choose` from outside are no candidate.
    NoCandidate(Vec<Value>),
    /// There is no main rule.
    NoMain,
}
