//! Ids of the terms and rules that were added to a model after its analysis.

use crate::id::FunctionId;

/// Index into [`Added::terms`](crate::Added::terms).
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct AddedTerm(pub u32);

/// Index into [`Added::rules`](crate::Added::rules).
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct AddedRule(pub u32);

/// An assignment from outside: a location and its new value, as in `set` of a scenario.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Assignment {
    /// Function of the location; may be monitored.
    pub function: FunctionId,
    /// Its arguments: one term for each parameter, or a single term for the tuple of all.
    pub arguments: Vec<AddedTerm>,
    /// The term whose value the location receives.
    pub value: AddedTerm,
}
