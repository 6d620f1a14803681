//! The subject and the limits of a verification.

use crate::explore::Limits;
use crate::mail::{ContentValues, MessageModel};
use crate::spill::SpillSpace;
use asmotion_lang::Value;
use asmotion_lang::ir::FunctionId;
use std::sync::Arc;

/// The values of an input, in place of those of its codomain.
#[derive(Clone, Debug)]
pub struct InputValues {
    /// Index of the machine that reads it.
    pub machine: usize,
    /// The monitored or shared function.
    pub function: FunctionId,
    /// Its possible values, in the order in which they are tried.
    pub values: Vec<Value>,
}

/// The name of a rule, or of a domain of agents, to which fairness is due.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct FairName {
    /// Name of the rule or domain.
    pub name: String,
    /// `true` for strong fairness: infinitely often enabled implies infinitely often moved. `false` for weak fairness: from
    /// some point on always enabled implies infinitely often moved.
    pub is_strong: bool,
}

/// The way in which states are explored.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Engine {
    /// One by one.
    #[default]
    Explicit,
    /// Sets of them, as decision diagrams.
    #[cfg(feature = "symbolic")]
    Symbolic,
}

/// The storage of states.
#[derive(Clone, Debug, Default)]
pub enum Storage {
    /// In memory.
    #[default]
    Exact,
    /// As fingerprints of 64 bits, if they are smaller than the states. States with the same fingerprint are taken for one state:
    /// see [`Verification::expected_missed`](crate::Verification::expected_missed). Advice needs exact states.
    Compact,
    /// In files, apart from an index of about 16 bytes for each state.
    Disk(Arc<dyn SpillSpace>),
}

/// The subject and the limits of a verification.
#[derive(Clone, Debug, Default)]
pub struct Options {
    /// Limits of the exploration.
    pub limits: Limits,
    /// Properties in addition to those of the specification: terms that are formulas of CTL or LTL, or invariants.
    pub properties: Vec<String>,
    /// Terms for which a run to a state is sought in which they are true.
    pub possible: Vec<String>,
    /// Names or texts of the properties to check; all if empty.
    pub only: Vec<String>,
    /// Conditions without which a state, together with its inputs, is not considered.
    pub assumptions: Vec<String>,
    /// Texts of constraints (`INVAR`) that are checked like invariants instead of being assumed: see
    /// [`state_constraints`](crate::state_constraints).
    pub checked_constraints: Vec<String>,
    /// Condition of the states in which nothing needs to change any more, besides those that `//@Final` names.
    pub ends: Option<String>,
    /// Rules and domains of agents to which fairness is due, besides those that `//@Fair` and `//@StronglyFair` name.
    pub fairness: Vec<FairName>,
    /// `true` to keep the states of runs: see [`Run::states`](crate::Run::states).
    pub keeps_states: bool,
    /// `true` to compute the advice.
    pub advice: bool,
    /// Inputs whose values are given; others have those of their codomains.
    pub inputs: Vec<InputValues>,
    /// Contents of messages from outside the system that are given; others have all values of their domains.
    pub contents: Vec<ContentValues>,
    /// The way in which states are explored.
    pub engine: Engine,
    /// `true` to explore one of several states that permutations of the elements of a domain make of each other, where that makes
    /// no difference: see [`Verification::symmetric`](crate::Verification::symmetric).
    pub symmetry: bool,
    /// `true` to leave out locations that the properties in `only` do not depend on, if these are about single states: see
    /// [`Verification::left_out`](crate::Verification::left_out).
    pub cone: bool,
    /// `true` to explore steps that do not influence each other in one order, if all properties are about single states: see
    /// [`Verification::has_left_out_steps`](crate::Verification::has_left_out_steps).
    pub independent: bool,
    /// The storage of states, if they are explored one by one.
    pub storage: Storage,
    /// Number of threads that explore states one by one; 0 counts as 1. The result does not depend on it.
    pub threads: usize,
    /// The transport of messages.
    pub messages: MessageModel,
    /// `true` to let a machine execute every step. By default, the steps of one specification over finite ranges are executed in
    /// grounded form, which is faster and gives the same result.
    pub without_grounding: bool,
}
