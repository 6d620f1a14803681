//! Generalised Büchi automata of LTL formulas, built state by state.
//!
//! A state is a set of obligations, which the rest of the path has to satisfy, and the history of the past operators. Reading a
//! position splits the obligations into what holds there and what is left for the next position (the tableau of Couvreur, "On-the-fly
//! verification of linear temporal logic", 1999). An obligation `p U q` can be postponed, but not for ever: the steps that do
//! not postpone it have to recur.

use crate::bits::Bits;
use crate::closure::{Closure, Letter, LtlId, LtlTerm, Past};
use crate::constraint::Constraint;
use crate::error::TemporalError;
use crate::fairness::{Fairness, Recurrent};
use crate::ltl::Ltl;
use crate::rows::SparseRows;
use crate::streett::fair_components;
use rustc_hash::FxHashMap;
use std::ops::Range;
use std::rc::Rc;

/// Largest number of alternatives at one position.
const ALTERNATIVES: usize = 1 << 13;

/// The automaton that accepts the paths that violate a formula.
pub(crate) struct Automaton {
    closure: Closure,
    /// The obligations `p U q`.
    untils: Vec<LtlId>,
    states: Vec<AutomatonState>,
    ids: FxHashMap<AutomatonState, u32>,
    steps: Vec<AutomatonStep>,
    known: FxHashMap<(u32, u32), Range<usize>>,
}

#[derive(Clone, Debug, PartialEq, Eq, Hash)]
struct AutomatonState {
    /// Terms.
    obligations: Bits,
    /// Values that the past operators remember.
    history: Bits,
}

/// A step of the automaton.
#[derive(Clone, Debug)]
pub(crate) struct AutomatonStep {
    pub(crate) target: u32,
    /// No obligation is left: every continuation is accepted.
    pub(crate) is_final: bool,
    /// Indices of the obligations that are postponed.
    pub(crate) postponed: Vec<usize>,
}

/// A way to satisfy formulas: what is left for the next position, and which of it is postponed.
#[derive(Clone, Debug, PartialEq, Eq)]
struct Alternative {
    next: Bits,
    postponed: Bits,
}

/// The values of letters at a position.
struct Position<'a> {
    atoms: &'a dyn Fn(usize) -> bool,
    past: Bits,
    guesses: usize,
    /// The formulas about the present that are true. Operands come before the terms that contain them, so one pass finds them.
    truths: Bits,
    /// Ways to satisfy terms, which several terms can share.
    ways: FxHashMap<LtlId, Rc<[Alternative]>>,
}

impl Position<'_> {
    fn holds(&self, letter: Letter) -> bool {
        match letter {
            Letter::Atom(atom) => (self.atoms)(atom),
            Letter::Past(past) => self.past.contains(past),
            Letter::Guess(guess) => self.guesses >> guess & 1 != 0,
        }
    }
}

impl Automaton {
    /// The state in which paths start.
    pub(crate) const START: u32 = 0;

    /// Returns the automaton of the negated formula.
    pub(crate) fn of_negation(formula: &Ltl, atom_count: usize) -> Result<Self, TemporalError> {
        let (closure, root) = Closure::of_negation(formula, atom_count)?;
        let is_until = |id: &LtlId| matches!(closure.terms[*id], LtlTerm::Until(_, _));
        let untils = (0..closure.terms.len()).filter(is_until).collect();
        let history = Bits::from_fn(closure.past.len(), |at| closure.past[at].before_start());
        let mut automaton = Self {
            closure,
            untils,
            states: Vec::new(),
            ids: FxHashMap::default(),
            steps: Vec::new(),
            known: FxHashMap::default(),
        };
        let mut obligations = automaton.no_terms();
        automaton.oblige(&mut obligations, root);
        automaton.state(AutomatonState {
            obligations,
            history,
        });
        Ok(automaton)
    }

    /// Returns the atoms that occur in the formula.
    pub(crate) fn atoms(&self) -> Vec<usize> {
        self.closure.atoms()
    }

    /// Returns the number of obligations that cannot be postponed for ever.
    pub(crate) fn until_count(&self) -> usize {
        self.untils.len()
    }

    /// Returns the steps from a state at a position; `letter` identifies the values of its atoms.
    pub(crate) fn steps(
        &mut self,
        state: u32,
        letter: u32,
        atoms: &dyn Fn(usize) -> bool,
    ) -> Result<&[AutomatonStep], TemporalError> {
        let range = match self.known.get(&(state, letter)) {
            Some(range) => range.clone(),
            None => {
                let begin = self.steps.len();
                self.add_steps(state, atoms)?;
                let range = begin..self.steps.len();
                self.known.insert((state, letter), range.clone());
                range
            }
        };
        Ok(self.steps.get(range).unwrap_or_default())
    }

    /// Returns the states that some run visits for ever without postponing an obligation for ever, as far as steps are known.
    pub(crate) fn recurrent_states(&self) -> Bits {
        let mut by_state = vec![Vec::new(); self.states.len()];
        for ((state, _), range) in &self.known {
            by_state[*state as usize].extend(range.clone());
        }
        let mut rows = SparseRows::new();
        let mut order = Vec::new();
        for steps in by_state {
            for step in steps {
                rows.push(self.steps[step].target);
                order.push(step);
            }
            rows.end_node();
        }
        let untils = 0..self.untils.len();
        let untils = untils.map(|until| {
            let postpones = |at: usize| self.steps[order[at]].postponed.contains(&until);
            let kept = Bits::from_fn(order.len(), |at| !postpones(at));
            Fairness::Justice(Recurrent::edges(kept))
        });
        let untils: Vec<Fairness> = untils.collect();
        let all = Bits::full(self.states.len());
        fair_components(&rows, &all, &Constraint::all(&untils)).members
    }

    fn add_steps(
        &mut self,
        state: u32,
        atoms: &dyn Fn(usize) -> bool,
    ) -> Result<(), TemporalError> {
        let from = self.states[state as usize].clone();
        for guesses in 0..1 << self.closure.guesses.len() {
            let mut position = Position {
                atoms,
                past: Bits::new(self.closure.past.len()),
                guesses,
                truths: self.no_terms(),
                ways: FxHashMap::default(),
            };
            let history = self.remember(&from.history, &mut position);
            let mut obligations: Vec<LtlId> = from.obligations.ones().collect();
            for (at, guess) in self.closure.guesses.iter().enumerate() {
                let holds = position.holds(Letter::Guess(at));
                obligations.push(if holds { guess.holds } else { guess.fails });
            }
            for alternative in self.all_of(&obligations, &mut position)? {
                self.add_step(alternative, history.clone());
            }
        }
        Ok(())
    }

    fn add_step(&mut self, alternative: Alternative, history: Bits) {
        let is_final = alternative.next.is_empty();
        let target = self.state(AutomatonState {
            obligations: alternative.next,
            history,
        });
        self.steps.push(AutomatonStep {
            target,
            is_final,
            postponed: alternative.postponed.ones().collect(),
        });
    }

    fn state(&mut self, state: AutomatonState) -> u32 {
        let states = &mut self.states;
        *self.ids.entry(state.clone()).or_insert_with(|| {
            states.push(state);
            states.len() as u32 - 1
        })
    }

    /// Evaluates the past operators at a position, and returns what they remember at the next.
    fn remember(&self, history: &Bits, position: &mut Position<'_>) -> Bits {
        let mut next = Bits::new(history.size());
        for (id, term) in self.closure.terms.iter().enumerate() {
            let truths = &position.truths;
            let is_true = match term {
                LtlTerm::Constant(value) => *value,
                LtlTerm::Literal {
                    letter,
                    is_positive,
                } => {
                    if let Letter::Past(past) = letter {
                        let before = history.contains(*past);
                        let (value, remembered) = self.recall(*past, before, truths);
                        if value {
                            position.past.insert(*past);
                        }
                        if remembered {
                            next.insert(*past);
                        }
                    }
                    position.holds(*letter) == *is_positive
                }
                LtlTerm::And(parts) => parts.iter().all(|it| truths.contains(*it)),
                LtlTerm::Or(parts) => parts.iter().any(|it| truths.contains(*it)),
                // guessed below past operators
                LtlTerm::Next(_) | LtlTerm::Until(_, _) | LtlTerm::Release(_, _) => false,
            };
            if is_true {
                position.truths.insert(id);
            }
        }
        next
    }

    /// Returns the value of a past operator, and what it remembers at the next position.
    fn recall(&self, past: usize, before: bool, truths: &Bits) -> (bool, bool) {
        match self.closure.past[past] {
            Past::Previous(of, _) => (before, truths.contains(of)),
            Past::Since(left, right) => {
                let kept = before && truths.contains(left);
                let value = kept || truths.contains(right);
                (value, value)
            }
            Past::Triggered(left, right) => {
                let kept = before || truths.contains(left);
                let value = kept && truths.contains(right);
                (value, value)
            }
        }
    }

    fn no_terms(&self) -> Bits {
        Bits::new(self.closure.terms.len())
    }

    /// Adds an obligation for the next position, conjunctions as their parts.
    fn oblige(&self, obligations: &mut Bits, id: LtlId) {
        match &self.closure.terms[id] {
            LtlTerm::Constant(true) => {}
            LtlTerm::And(parts) => parts.iter().for_each(|it| self.oblige(obligations, *it)),
            LtlTerm::Constant(false)
            | LtlTerm::Literal { .. }
            | LtlTerm::Or(_)
            | LtlTerm::Next(_)
            | LtlTerm::Until(_, _)
            | LtlTerm::Release(_, _) => {
                obligations.insert(id);
            }
        }
    }

    /// Removes obligations that others imply: `p V q` implies `q`.
    fn reduce(&self, obligations: &mut Bits) {
        let all: Vec<LtlId> = obligations.ones().collect();
        for id in all {
            if let LtlTerm::Release(_, right) = &self.closure.terms[id] {
                match &self.closure.terms[*right] {
                    LtlTerm::And(parts) => parts.iter().for_each(|it| obligations.remove(*it)),
                    LtlTerm::Constant(_)
                    | LtlTerm::Literal { .. }
                    | LtlTerm::Or(_)
                    | LtlTerm::Next(_)
                    | LtlTerm::Until(_, _)
                    | LtlTerm::Release(_, _) => {}
                }
                obligations.remove(*right);
            }
        }
    }

    /// Returns the ways to satisfy all formulas.
    fn all_of(
        &self,
        ids: &[LtlId],
        position: &mut Position<'_>,
    ) -> Result<Vec<Alternative>, TemporalError> {
        let mut found = vec![self.satisfied()];
        for id in ids {
            found = both(&found, &self.ways(*id, position)?)?;
        }
        for alternative in &mut found {
            self.reduce(&mut alternative.next);
        }
        Ok(least(found))
    }

    fn satisfied(&self) -> Alternative {
        Alternative {
            next: self.no_terms(),
            postponed: Bits::new(self.untils.len()),
        }
    }

    /// Returns the alternative that leaves one formula for the next position; none for `false`.
    fn later(&self, id: LtlId) -> Vec<Alternative> {
        if self.closure.terms[id] == LtlTerm::Constant(false) {
            return Vec::new();
        }
        let mut alternative = self.satisfied();
        self.oblige(&mut alternative.next, id);
        vec![alternative]
    }

    /// Returns the ways to satisfy a formula at a position.
    fn ways(
        &self,
        id: LtlId,
        position: &mut Position<'_>,
    ) -> Result<Rc<[Alternative]>, TemporalError> {
        if let Some(ways) = position.ways.get(&id) {
            return Ok(Rc::clone(ways));
        }
        let ways: Rc<[Alternative]> = self.new_ways(id, position)?.into();
        position.ways.insert(id, Rc::clone(&ways));
        Ok(ways)
    }

    fn new_ways(
        &self,
        id: LtlId,
        position: &mut Position<'_>,
    ) -> Result<Vec<Alternative>, TemporalError> {
        match &self.closure.terms[id] {
            LtlTerm::Constant(_) | LtlTerm::Literal { .. } => {
                let is_true = position.truths.contains(id);
                Ok(is_true.then(|| self.satisfied()).into_iter().collect())
            }
            LtlTerm::And(parts) => {
                let mut found = vec![self.satisfied()];
                for part in parts {
                    found = both(&found, &self.ways(*part, position)?)?;
                }
                Ok(found)
            }
            LtlTerm::Or(parts) => {
                let mut found = Vec::new();
                for part in parts {
                    found.extend_from_slice(&self.ways(*part, position)?);
                    found = bounded(least(found))?;
                }
                Ok(found)
            }
            LtlTerm::Next(of) => Ok(self.later(*of)),
            LtlTerm::Until(left, right) => {
                let mut postponed = self.later(id);
                for alternative in &mut postponed {
                    let index = self.untils.partition_point(|until| *until < id);
                    alternative.postponed.insert(index);
                }
                let mut found = both(&self.ways(*left, position)?, &postponed)?;
                found.extend_from_slice(&self.ways(*right, position)?);
                bounded(least(found))
            }
            LtlTerm::Release(left, right) => {
                let mut found = self.ways(*left, position)?.to_vec();
                found.extend(self.later(id));
                both(&self.ways(*right, position)?, &least(found))
            }
        }
    }
}

/// Returns the ways to satisfy two formulas.
fn both(left: &[Alternative], right: &[Alternative]) -> Result<Vec<Alternative>, TemporalError> {
    if left.len().saturating_mul(right.len()) > ALTERNATIVES {
        let limit = ALTERNATIVES;
        return Err(TemporalError::FormulaTooLarge { limit });
    }
    let pairs = left
        .iter()
        .flat_map(|left| right.iter().map(move |right| (left, right)));
    let joined = pairs.map(|(left, right)| {
        let mut joined = left.clone();
        joined.next.union_with(&right.next);
        joined.postponed.union_with(&right.postponed);
        joined
    });
    Ok(least(joined.collect()))
}

fn bounded(found: Vec<Alternative>) -> Result<Vec<Alternative>, TemporalError> {
    let limit = ALTERNATIVES;
    if found.len() > limit {
        return Err(TemporalError::FormulaTooLarge { limit });
    }
    Ok(found)
}

/// Removes alternatives that leave more, and postpone more, than others: whatever they accept, the others accept.
fn least(found: Vec<Alternative>) -> Vec<Alternative> {
    let mut kept: Vec<Alternative> = Vec::new();
    for alternative in found {
        let is_least = |less: &Alternative, more: &Alternative| {
            less.next.is_subset(&more.next) && less.postponed.is_subset(&more.postponed)
        };
        if kept.iter().any(|other| is_least(other, &alternative)) {
            continue;
        }
        kept.retain(|other| !is_least(&alternative, other));
        kept.push(alternative);
    }
    kept
}
