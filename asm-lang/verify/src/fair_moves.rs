//! Steps to which fairness is due: those of an agent or of a rule.
//!
//! A step *moves* an agent if a `choose` rule takes the agent as the value of a variable that ranges over its domain, and it moves a
//! rule if it executes that rule; in both cases only if the step changes the state.

use crate::transition::TransitionSystem;
use asmotion_lang::Value;
use asmotion_lang::ir::Origin;
use std::collections::BTreeMap;

/// Limit for the agents and rules to which fairness is due.
pub(crate) const MAX_FAIR_MOVES: usize = 96;

/// The agents and rules that a step moves.
#[derive(Clone, Debug)]
pub(crate) enum MovedBy {
    /// A rule, given by its coverage counters.
    Rule(Vec<u32>),
    /// The agent with this value. The places are those of `choose` rules with a variable that ranges over its domain, given by its
    /// position.
    Agent(Value, BTreeMap<Origin, usize>),
}

/// An agent or rule to which fairness is due.
#[derive(Clone, Debug)]
pub(crate) struct FairMove {
    pub machine: usize,
    pub moved_by: MovedBy,
    /// `true` for strong fairness.
    pub is_strong: bool,
}

/// The agents and rules that a step moves: the label that the system gives the step, and above it bits for the agents and rules, in the order of
/// [`FairMoves::moves`].
pub(crate) type MovedSet = u128;

/// Bits of the system's label.
const LABEL_BITS: usize = 32;

/// Returns `true` if a step moves the agent or rule with this index.
pub(crate) fn contains(set: MovedSet, index: usize) -> bool {
    set >> (LABEL_BITS + index) & 1 == 1
}

/// Returns the label that the system gives a step.
pub(crate) fn label_of(set: MovedSet) -> u32 {
    (set & MovedSet::from(u32::MAX)) as u32
}

/// The agents and rules to which fairness is due.
#[derive(Clone, Debug, Default)]
pub(crate) struct FairMoves {
    pub moves: Vec<FairMove>,
}

/// The coverage counts before a step.
#[derive(Debug, Default)]
pub(crate) struct CountsBefore(Vec<u64>);

impl FairMoves {
    /// Returns `true` if nothing is to be observed.
    pub fn is_empty(&self) -> bool {
        self.moves.is_empty()
    }

    /// Returns `true` if agents are to be observed, for which the system has to keep candidates.
    pub fn has_agents(&self) -> bool {
        let is_agent = |it: &FairMove| matches!(it.moved_by, MovedBy::Agent(..));
        self.moves.iter().any(is_agent)
    }

    /// Returns what a step of the first machine moves that takes these candidates, given by the places of their rules and their
    /// values, and increments these coverage counters, if it changes the state.
    pub fn of_step<'c>(
        &self,
        candidates: impl Iterator<Item = (Origin, &'c [Value])> + Clone,
        counters: &[u32],
    ) -> MovedSet {
        let mut set = 0;
        for (index, fair) in self.moves.iter().enumerate() {
            let has_moved = match &fair.moved_by {
                MovedBy::Rule(own) => own.iter().any(|counter| counters.contains(counter)),
                MovedBy::Agent(agent, places) => {
                    let mut all = candidates.clone();
                    all.any(|(origin, values)| {
                        let at = places.get(&origin);
                        at.and_then(|at| values.get(*at)) == Some(agent)
                    })
                }
            };
            set |= MovedSet::from(has_moved) << (LABEL_BITS + index);
        }
        set
    }

    /// Notes the counts before a step.
    pub fn before<S: TransitionSystem>(&self, system: &S, counts: &mut CountsBefore) {
        counts.0.clear();
        let calls = self.moves.iter().map(|it| calls(it, system));
        counts.0.extend(calls);
    }

    /// Returns what the last step moved.
    pub fn moved<S: TransitionSystem>(
        &self,
        system: &S,
        counts: &CountsBefore,
        is_changed: bool,
    ) -> MovedSet {
        let mut set = MovedSet::from(system.label());
        for (index, fair) in self.moves.iter().enumerate() {
            let before = counts.0.get(index).copied().unwrap_or_default();
            let has_moved = is_changed
                && system.moved().contains(&fair.machine)
                && match &fair.moved_by {
                    MovedBy::Rule(_) => calls(fair, system) > before,
                    MovedBy::Agent(agent, places) => picks(fair.machine, agent, places, system),
                };
            set |= MovedSet::from(has_moved) << (LABEL_BITS + index);
        }
        set
    }
}

fn calls<S: TransitionSystem>(fair: &FairMove, system: &S) -> u64 {
    let machine = system.machines().get(fair.machine);
    match (&fair.moved_by, machine) {
        (MovedBy::Rule(counters), Some(machine)) => {
            counters.iter().map(|counter| machine.count(*counter)).sum()
        }
        (MovedBy::Rule(_) | MovedBy::Agent(..), _) => 0,
    }
}

fn picks<S: TransitionSystem>(
    machine: usize,
    agent: &Value,
    places: &BTreeMap<Origin, usize>,
    system: &S,
) -> bool {
    let machine = system.machines().get(machine);
    let candidates = machine.map(|it| it.last_step().candidates());
    candidates.unwrap_or_default().iter().any(|candidate| {
        let at = places.get(&candidate.origin);
        at.and_then(|at| candidate.values.get(*at)) == Some(agent)
    })
}
