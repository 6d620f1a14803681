//! Numbers of what was added to a model.

use crate::id::FunctionId;

/// A term that was added, by number.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct AddedTerm(pub u32);

/// A rule that was added, by number.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct AddedRule(pub u32);

/// A location from outside, and the value it is to have.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Assignment {
    /// The function.
    pub function: FunctionId,
    /// Its arguments: one for each parameter, or a tuple of all.
    pub arguments: Vec<AddedTerm>,
    /// The value.
    pub value: AddedTerm,
}
