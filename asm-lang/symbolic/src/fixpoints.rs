//! Operators of branching time on sets of nodes, under fairness.

use crate::bdd::{Bdd, BddStore};
use crate::error::SymbolicError;

/// A fairness constraint on the nodes of a path.
pub(crate) enum FairSet {
    /// Infinitely often in the set.
    Justice(Bdd),
    /// If infinitely often in the first set, then infinitely often in the second.
    Compassion(Bdd, Bdd),
}

/// The predecessors of a set.
pub(crate) type Predecessors<'a> = &'a dyn Fn(&Bdd) -> Result<Bdd, SymbolicError>;

/// A total relation between nodes, and the paths that count.
pub(crate) struct Fixpoints<'a> {
    pub store: &'a BddStore<'a>,
    pub nodes: Bdd,
    pub predecessors: Predecessors<'a>,
    pub fairness: &'a [FairSet],
}

impl Fixpoints<'_> {
    fn check(&self) -> Result<(), SymbolicError> {
        self.store.tidy();
        self.store.check()
    }

    /// `EX set`, without fairness.
    pub fn next(&self, set: &Bdd) -> Result<Bdd, SymbolicError> {
        self.check()?;
        self.store.and(&(self.predecessors)(set)?, &self.nodes)
    }

    /// `E[through U goal]`, without fairness.
    pub fn until(&self, through: &Bdd, goal: &Bdd) -> Result<Bdd, SymbolicError> {
        let mut found = self.store.and(goal, &self.nodes)?;
        let mut frontier = found.clone();
        while !frontier.is_never() {
            let before = self.store.and(&self.next(&frontier)?, through)?;
            frontier = self.store.without(&before, &found)?;
            found = self.store.or(&found, &frontier)?;
        }
        Ok(found)
    }

    /// `EG set` on fair paths.
    pub fn globally(&self, set: &Bdd) -> Result<Bdd, SymbolicError> {
        let hull = self.hull(set)?;
        if self.fairness.is_empty() {
            return Ok(hull);
        }
        self.until(set, &hull)
    }

    /// The greatest set of nodes within `set` from which every node of it can continue within it, reaches each just set, and reaches
    /// the second set of each compassion if it is in the first (Kesten, Pnueli, Raviv).
    fn hull(&self, set: &Bdd) -> Result<Bdd, SymbolicError> {
        let mut kept = self.store.and(set, &self.nodes)?;
        loop {
            let before = kept.clone();
            kept = self.for_ever(&kept)?;
            for constraint in self.fairness {
                match constraint {
                    FairSet::Justice(often) => {
                        let goal = self.store.and(&kept, often)?;
                        let reaching = self.until(&kept, &goal)?;
                        kept = self.store.and(&kept, &reaching)?;
                    }
                    FairSet::Compassion(cause, effect) => {
                        let goal = self.store.and(&kept, effect)?;
                        let reaching = self.until(&kept, &goal)?;
                        let rest = self.store.without(&kept, cause)?;
                        let reaching = self.store.and(&kept, &reaching)?;
                        kept = self.store.or(&rest, &reaching)?;
                    }
                }
            }
            if kept == before {
                return Ok(kept);
            }
        }
    }

    /// `EG set` without fairness.
    fn for_ever(&self, set: &Bdd) -> Result<Bdd, SymbolicError> {
        let mut kept = set.clone();
        loop {
            let next = self.store.and(&kept, &self.next(&kept)?)?;
            if next == kept {
                return Ok(kept);
            }
            kept = next;
        }
    }

    /// The nodes from which fair paths start.
    pub fn fair(&self) -> Result<Bdd, SymbolicError> {
        if self.fairness.is_empty() {
            return Ok(self.nodes.clone());
        }
        self.globally(&self.nodes)
    }
}
