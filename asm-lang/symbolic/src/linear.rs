//! LTL: a tableau of the formula as further variables, so that a fair path of the product satisfies it.

use crate::bdd::{Bdd, BddStore, BitIndex, Renaming};
use crate::error::SymbolicError;
use crate::fixpoints::{FairSet, Fixpoints, Predecessors};
use asmotion_temporal::Ltl;

/// A variable of a tableau.
#[derive(Clone, Copy)]
enum Elementary {
    /// True if the formula holds in the next node.
    Next,
    /// True if the formula holds in the previous node; at the beginning it has this value.
    Previous(bool),
}

/// The tableau of a formula.
pub(crate) struct Tableau<'a> {
    store: &'a BddStore<'a>,
    atoms: &'a [Bdd],
    /// Each variable with its bit, and the function that it announces or recalls.
    variables: Vec<(Elementary, BitIndex, Bdd)>,
    /// Condition of each until that must hold infinitely often.
    promises: Vec<Bdd>,
}

impl<'a> Tableau<'a> {
    pub fn new(store: &'a BddStore<'a>, atoms: &'a [Bdd]) -> Self {
        Self {
            store,
            atoms,
            variables: Vec::new(),
            promises: Vec::new(),
        }
    }

    fn elementary(&mut self, kind: Elementary, of: Bdd) -> Result<Bdd, SymbolicError> {
        let bit = self.store.add_bits(1)?;
        self.variables.push((kind, bit, of));
        self.store.bit(bit, true)
    }

    /// `left U right`: now, or left now and again in the next node.
    fn until(&mut self, left: &Bdd, right: &Bdd) -> Result<Bdd, SymbolicError> {
        let bit = self.store.add_bits(1)?;
        let next = self.store.bit(bit, true)?;
        let holds = self.store.or(right, &self.store.and(left, &next)?)?;
        self.variables.push((Elementary::Next, bit, holds.clone()));
        let otherwise = self.store.not(&holds)?;
        self.promises.push(self.store.or(&otherwise, right)?);
        Ok(holds)
    }

    /// `left S right`: now, or left now and already in the previous node.
    fn since(&mut self, left: &Bdd, right: &Bdd) -> Result<Bdd, SymbolicError> {
        let bit = self.store.add_bits(1)?;
        let previous = self.store.bit(bit, true)?;
        let holds = self.store.or(right, &self.store.and(left, &previous)?)?;
        let kind = Elementary::Previous(false);
        self.variables.push((kind, bit, holds.clone()));
        Ok(holds)
    }

    /// Returns the function that is true where a formula holds.
    pub fn holds(&mut self, formula: &Ltl) -> Result<Bdd, SymbolicError> {
        stacker::maybe_grow(64 * 1024, 1024 * 1024, || self.holds_here(formula))
    }

    fn not(&mut self, formula: &Ltl) -> Result<Bdd, SymbolicError> {
        let holds = self.holds(formula)?;
        self.store.not(&holds)
    }

    fn holds_here(&mut self, formula: &Ltl) -> Result<Bdd, SymbolicError> {
        let store = self.store;
        match formula {
            Ltl::True => Ok(store.always()),
            Ltl::False => Ok(store.never()),
            Ltl::Atom(atom) => Ok(self
                .atoms
                .get(*atom)
                .cloned()
                .unwrap_or_else(|| store.never())),
            Ltl::Not(of) => self.not(of),
            Ltl::And(parts) => {
                let mut all = store.always();
                for part in parts {
                    all = store.and(&all, &self.holds(part)?)?;
                }
                Ok(all)
            }
            Ltl::Or(parts) => {
                let mut any = store.never();
                for part in parts {
                    any = store.or(&any, &self.holds(part)?)?;
                }
                Ok(any)
            }
            Ltl::Implies(left, right) => {
                let left = self.not(left)?;
                store.or(&left, &self.holds(right)?)
            }
            Ltl::Iff(left, right) => {
                let left = self.holds(left)?;
                store.same(&left, &self.holds(right)?)
            }
            Ltl::Next(of) => {
                let of = self.holds(of)?;
                self.elementary(Elementary::Next, of)
            }
            Ltl::Finally(of) => {
                let of = self.holds(of)?;
                self.until(&store.always(), &of)
            }
            Ltl::Globally(of) => {
                let not = self.not(of)?;
                let never = self.until(&store.always(), &not)?;
                store.not(&never)
            }
            Ltl::Until(left, right) => {
                let (left, right) = (self.holds(left)?, self.holds(right)?);
                self.until(&left, &right)
            }
            Ltl::Release(left, right) => {
                let (left, right) = (self.not(left)?, self.not(right)?);
                let not = self.until(&left, &right)?;
                store.not(&not)
            }
            Ltl::WeakUntil(left, right) => {
                // ¬(¬right U ¬left ∧ ¬right)
                let (left, right) = (self.not(left)?, self.not(right)?);
                let not = self.until(&right, &store.and(&left, &right)?)?;
                store.not(&not)
            }
            Ltl::Yesterday(of) => {
                let of = self.holds(of)?;
                self.elementary(Elementary::Previous(false), of)
            }
            Ltl::WeakYesterday(of) => {
                let of = self.holds(of)?;
                self.elementary(Elementary::Previous(true), of)
            }
            Ltl::Once(of) => {
                let of = self.holds(of)?;
                self.since(&store.always(), &of)
            }
            Ltl::Historically(of) => {
                let not = self.not(of)?;
                let once = self.since(&store.always(), &not)?;
                store.not(&once)
            }
            Ltl::Since(left, right) => {
                let (left, right) = (self.holds(left)?, self.holds(right)?);
                self.since(&left, &right)
            }
            Ltl::Triggered(left, right) => {
                let (left, right) = (self.not(left)?, self.not(right)?);
                let not = self.since(&left, &right)?;
                store.not(&not)
            }
        }
    }

    /// Returns the initial nodes from which a fair path satisfies a formula.
    pub fn satisfying(
        &mut self,
        formula: &Ltl,
        initial: &Bdd,
        graph: &Fixpoints<'_>,
    ) -> Result<Bdd, SymbolicError> {
        let store = self.store;
        let holds = self.holds(formula)?;
        let product = Product::of(store, &self.variables)?;
        let predecessors = |set: &Bdd| product.predecessors(store, graph.predecessors, set);
        let mut fairness: Vec<FairSet> = Vec::new();
        for constraint in graph.fairness {
            fairness.push(match constraint {
                FairSet::Justice(often) => FairSet::Justice(often.clone()),
                FairSet::Compassion(cause, effect) => {
                    FairSet::Compassion(cause.clone(), effect.clone())
                }
            });
        }
        fairness.extend(self.promises.iter().cloned().map(FairSet::Justice));
        let fixpoints = Fixpoints {
            store,
            nodes: graph.nodes.clone(),
            predecessors: &predecessors,
            fairness: &fairness,
        };
        let fair = fixpoints.globally(&graph.nodes)?;
        let mut found = store.and(&store.and(initial, &holds)?, &fair)?;
        for (kind, bit, _) in &self.variables {
            if let Elementary::Previous(value) = kind {
                found = store.and(&found, &store.bit(*bit, *value)?)?;
            }
        }
        let bits: Vec<BitIndex> = self.variables.iter().map(|(_, bit, _)| *bit).collect();
        store.exists(&found, &store.bits(&bits)?)
    }
}

/// The product of nodes with the variables of a tableau.
struct Product {
    /// Each variable `Next` before the step is what its function is after it.
    announced: Bdd,
    /// Each variable `Previous` after the step is what its function was before it.
    recalled: Bdd,
    /// Variables after the step: `Next`, `Previous`.
    next: Bdd,
    previous: Bdd,
    to_current: Renaming,
}

impl Product {
    fn of(
        store: &BddStore,
        variables: &[(Elementary, BitIndex, Bdd)],
    ) -> Result<Self, SymbolicError> {
        let first = store.add_bits(variables.len() as u32)?;
        let earlier = |index: usize| first + index as u32;
        let pairs: Vec<(BitIndex, BitIndex)> = variables
            .iter()
            .enumerate()
            .map(|(index, (_, bit, _))| (*bit, earlier(index)))
            .collect();
        let to_earlier = store.renaming(&pairs);
        let reversed: Vec<(BitIndex, BitIndex)> = pairs
            .iter()
            .map(|(bit, earlier)| (*earlier, *bit))
            .collect();
        let (mut announced, mut recalled) = (store.always(), store.always());
        let (mut next, mut previous) = (Vec::new(), Vec::new());
        for (index, (kind, bit, of)) in variables.iter().enumerate() {
            match kind {
                Elementary::Next => {
                    let same = store.same(&store.bit(earlier(index), true)?, of)?;
                    announced = store.and(&announced, &same)?;
                    next.push(*bit);
                }
                Elementary::Previous(_) => {
                    let before = store.rename(of, &to_earlier)?;
                    let same = store.same(&store.bit(*bit, true)?, &before)?;
                    recalled = store.and(&recalled, &same)?;
                    previous.push(*bit);
                }
            }
        }
        Ok(Self {
            announced,
            recalled,
            next: store.bits(&next)?,
            previous: store.bits(&previous)?,
            to_current: store.renaming(&reversed),
        })
    }

    fn predecessors(
        &self,
        store: &BddStore,
        of_nodes: Predecessors<'_>,
        set: &Bdd,
    ) -> Result<Bdd, SymbolicError> {
        let after = store.and_exists(set, &self.announced, &self.next)?;
        let before = of_nodes(&after)?;
        let before = store.and_exists(&before, &self.recalled, &self.previous)?;
        store.rename(&before, &self.to_current)
    }
}
