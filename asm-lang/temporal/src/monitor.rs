//! Monitors: what one run, seen position by position, shows about a formula of linear temporal logic.
//!
//! A monitor watches the safety part of a formula: the formula in positive normal form, in which *until* is weakened to *weak until*
//! and *eventually* to true. What violates this part violates the formula, whatever follows. The state of a monitor is a set of
//! alternatives, each a set of subformulas that the next position has to satisfy (progression, after Bacchus and Kabanza, "Using
//! temporal logics to express search control knowledge for planning", 2000); alternatives that contain another one are dropped, so
//! there are finitely many states. Past operators are bits of a memory.
//!
//! Atoms may be unknown at a position: a monitor then reports a violation only if their values make no difference.

use crate::ctl::Ctl;
use crate::ltl::Ltl;
use crate::past::Letter;
use crate::safety::{self, NotMonitorable, SafetyForm, SafetyNode};
use std::collections::BTreeSet;

/// A formula compiled for monitoring. It is immutable; [`MonitorState`] is what a run changes.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Monitor(SafetyForm);

/// State of a monitor in a run.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct MonitorState {
    /// Alternatives: sorted sets of subformulas that the current position has to satisfy, none of which contains another.
    pub alternatives: Vec<Vec<u32>>,
    /// Memory of the past operators.
    pub memory: Vec<bool>,
}

/// The verdict about a run so far.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MonitorVerdict {
    /// Nothing that follows violates the watched part.
    Satisfied,
    /// Neither violated nor satisfied.
    Open,
    /// Violated, whatever follows.
    Violated,
}

impl Monitor {
    /// Compiles a formula of LTL.
    ///
    /// # Errors
    /// No finite run violates it, or it is too large.
    pub fn of_ltl(formula: &Ltl) -> Result<Self, NotMonitorable> {
        SafetyForm::of(formula, BTreeSet::new()).map(Self)
    }

    /// Compiles a formula of CTL. A run shows violations of those parts that are about all paths.
    ///
    /// # Errors
    /// As [`Self::of_ltl`], or it is about the existence of paths only.
    pub fn of_ctl(formula: &Ctl) -> Result<Self, NotMonitorable> {
        let mut unwatched = BTreeSet::new();
        let linear = safety::linear(formula, true, &mut unwatched);
        SafetyForm::of(&linear, unwatched).map(Self)
    }

    /// The reasons for which parts of the formula are not watched; empty if all of it is.
    pub fn unwatched(&self) -> impl Iterator<Item = NotMonitorable> {
        self.0.unwatched.iter().copied()
    }

    /// Returns `true` if the formula says what always holds, so that a monitor can begin anew after a violation.
    pub fn is_repeated(&self) -> bool {
        matches!(self.0.nodes.get(self.0.root), Some(SafetyNode::Release(left, _))
            if matches!(self.0.nodes.get(*left), Some(SafetyNode::Any(parts)) if parts.is_empty()))
    }

    /// Returns the state before the first position.
    pub fn begin(&self) -> MonitorState {
        MonitorState {
            alternatives: vec![vec![self.0.root as u32]],
            memory: self.0.conditions.memory(),
        }
    }

    /// Returns `true` if a state can be one of this monitor.
    pub fn fits(&self, state: &MonitorState) -> bool {
        let nodes = self.0.nodes.len();
        let mut pending = state.alternatives.iter().flatten();
        state.memory.len() == self.0.conditions.memory().len()
            && pending.all(|node| (*node as usize) < nodes)
    }

    /// Judges the run with the current position, of which some atoms may be unknown. The run does not go on to the next one.
    pub fn judge(&self, state: &MonitorState, letter: Letter<'_>) -> MonitorVerdict {
        verdict(&self.progressed(&state.alternatives, &state.memory, letter))
    }

    /// Judges the run with the current position, and goes on to the next one. After a violation, a formula about what always holds
    /// begins anew; any other one stays violated.
    pub fn pass(&self, state: &mut MonitorState, letter: Letter<'_>) -> MonitorVerdict {
        let mut alternatives = self.progressed(&state.alternatives, &state.memory, letter);
        let verdict = verdict(&alternatives);
        if verdict == MonitorVerdict::Violated && self.is_repeated() {
            // what the position itself demands of the next ones is kept
            let anew = vec![vec![self.0.root as u32]];
            alternatives = self.progressed(&anew, &state.memory, letter);
            if alternatives.is_empty() {
                alternatives = anew;
            }
        }
        let values = self.0.conditions.values(&state.memory, letter);
        self.0
            .conditions
            .remember(&mut state.memory, &values, letter);
        state.alternatives = alternatives;
        verdict
    }

    /// Returns what the next position has to satisfy.
    fn progressed(
        &self,
        alternatives: &[Vec<u32>],
        memory: &[bool],
        letter: Letter<'_>,
    ) -> Vec<Vec<u32>> {
        let values = self.0.conditions.values(memory, letter);
        let holds = |condition: usize| self.0.conditions.value(condition, &values, letter);
        let mut progress = Progression {
            nodes: &self.0.nodes,
            holds: &holds,
        };
        let mut result = Vec::new();
        for alternative in alternatives {
            let parts = alternative.iter().map(|node| *node as usize);
            result.extend(progress.all(parts));
        }
        minimal(result)
    }
}

fn verdict(alternatives: &[Vec<u32>]) -> MonitorVerdict {
    match alternatives {
        [] => MonitorVerdict::Violated,
        [only] if only.is_empty() => MonitorVerdict::Satisfied,
        _ => MonitorVerdict::Open,
    }
}

/// The progression of subformulas through one position.
struct Progression<'a> {
    nodes: &'a [SafetyNode],
    holds: &'a dyn Fn(usize) -> Option<bool>,
}

impl Progression<'_> {
    fn node(&mut self, index: usize) -> Vec<Vec<u32>> {
        let nodes = self.nodes;
        match nodes.get(index) {
            // the value of an unknown condition may turn out to be the right one
            Some(SafetyNode::Condition(condition, wanted)) => match (self.holds)(*condition) {
                Some(value) if value != *wanted => Vec::new(),
                Some(_) | None => vec![Vec::new()],
            },
            Some(SafetyNode::All(parts)) => self.all(parts.iter().copied()),
            Some(SafetyNode::Any(parts)) => {
                let parts = parts.iter().flat_map(|part| self.node(*part));
                minimal(parts.collect())
            }
            Some(SafetyNode::Next(operand)) => vec![vec![*operand as u32]],
            Some(SafetyNode::Release(left, right)) => {
                let right = self.node(*right);
                if right.is_empty() {
                    return right;
                }
                let mut released = self.node(*left);
                released.push(vec![index as u32]);
                product(&right, &minimal(released))
            }
            None => vec![Vec::new()],
        }
    }

    fn all(&mut self, parts: impl Iterator<Item = usize>) -> Vec<Vec<u32>> {
        let mut result = vec![Vec::new()];
        for part in parts {
            result = product(&result, &self.node(part));
            if result.is_empty() {
                break;
            }
        }
        result
    }
}

/// Returns the alternatives of a conjunction.
fn product(left: &[Vec<u32>], right: &[Vec<u32>]) -> Vec<Vec<u32>> {
    let mut result = Vec::with_capacity(left.len() * right.len());
    for one in left {
        for other in right {
            let mut both: Vec<u32> = one.iter().chain(other).copied().collect();
            both.sort_unstable();
            both.dedup();
            result.push(both);
        }
    }
    minimal(result)
}

/// Drops alternatives that contain another one.
fn minimal(mut alternatives: Vec<Vec<u32>>) -> Vec<Vec<u32>> {
    if alternatives.len() < 2 {
        return alternatives;
    }
    alternatives.sort_by(|one, other| one.len().cmp(&other.len()).then_with(|| one.cmp(other)));
    let mut kept: Vec<Vec<u32>> = Vec::with_capacity(alternatives.len());
    for alternative in alternatives {
        let is_part = |it: &Vec<u32>| {
            it.iter()
                .all(|node| alternative.binary_search(node).is_ok())
        };
        if !kept.iter().any(is_part) {
            kept.push(alternative);
        }
    }
    kept
}
