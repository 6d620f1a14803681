//! The kinds of faults that a symbolic evaluation distinguishes.

use asmotion_lang::FaultKind;

/// The kind of a fault, without its values.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum FaultClass {
    /// Inconsistent update set.
    Clash,
    /// A value outside the codomain.
    Outside,
    /// An argument outside the domain.
    OutsideArgument,
    /// An undefined guard.
    UndefinedGuard,
    /// A library function is undefined for its arguments.
    Library,
    /// A variable ranges over a value that is not a collection.
    NotACollection,
    /// A term run as a rule has another value.
    NotARule,
    /// A rule value is run with the wrong number of arguments.
    RuleArity,
    /// An agent without a program is run.
    NoProgram,
    /// Any other one.
    Other,
}

impl FaultClass {
    /// Returns the class of a fault.
    pub fn of(kind: &FaultKind) -> Self {
        match kind {
            FaultKind::Clash { .. } => Self::Clash,
            FaultKind::Outside { .. } => Self::Outside,
            FaultKind::OutsideArgument { .. } => Self::OutsideArgument,
            FaultKind::UndefinedGuard => Self::UndefinedGuard,
            FaultKind::Library(_) => Self::Library,
            FaultKind::NotACollection(_) => Self::NotACollection,
            FaultKind::NotARule(_) => Self::NotARule,
            FaultKind::RuleArity { .. } => Self::RuleArity,
            FaultKind::NoProgram(_) => Self::NoProgram,
            FaultKind::OutsideInput { .. }
            | FaultKind::Infinite
            | FaultKind::TooDeep(_)
            | FaultKind::ManyCalls(_)
            | FaultKind::Endless(_)
            | FaultKind::TooLarge(_)
            | FaultKind::Unbound
            | FaultKind::Unbounded
            | FaultKind::Input { .. }
            | FaultKind::Invariant { .. }
            | FaultKind::NoInputs { .. }
            | FaultKind::NoCandidate(_)
            | FaultKind::NoMain => Self::Other,
        }
    }
}
