//! CTL: the nodes in which a formula holds.

use crate::bdd::Bdd;
use crate::error::SymbolicError;
use crate::fixpoints::Fixpoints;
use asmotion_temporal::Ctl;

/// The evaluation of CTL formulas.
pub(crate) struct Branching<'a> {
    pub graph: Fixpoints<'a>,
    pub atoms: &'a [Bdd],
    /// The nodes from which fair paths start.
    pub fair: Bdd,
}

impl Branching<'_> {
    /// Returns the nodes in which a formula holds.
    pub fn holds(&self, formula: &Ctl) -> Result<Bdd, SymbolicError> {
        stacker::maybe_grow(64 * 1024, 1024 * 1024, || self.holds_here(formula))
    }

    fn not(&self, set: &Bdd) -> Result<Bdd, SymbolicError> {
        self.graph.store.without(&self.graph.nodes, set)
    }

    fn next(&self, set: &Bdd) -> Result<Bdd, SymbolicError> {
        self.graph.next(&self.graph.store.and(set, &self.fair)?)
    }

    fn until(&self, through: &Bdd, goal: &Bdd) -> Result<Bdd, SymbolicError> {
        let goal = self.graph.store.and(goal, &self.fair)?;
        self.graph.until(through, &goal)
    }

    /// `E[through W goal]`
    fn weak_until(&self, through: &Bdd, goal: &Bdd) -> Result<Bdd, SymbolicError> {
        let until = self.until(through, goal)?;
        self.graph.store.or(&until, &self.graph.globally(through)?)
    }

    fn repeated(&self, steps: u32, set: Bdd) -> Result<Bdd, SymbolicError> {
        let mut set = set;
        // the sets may repeat with a period
        let mut earlier = set.clone();
        let (mut rest, mut distance, mut patience) = (steps, 0, 1);
        while rest > 0 {
            set = self.next(&set)?;
            rest -= 1;
            distance += 1;
            if set == earlier {
                rest %= distance;
            }
            if distance == patience {
                earlier = set.clone();
                distance = 0;
                patience *= 2;
            }
        }
        Ok(set)
    }

    fn holds_here(&self, formula: &Ctl) -> Result<Bdd, SymbolicError> {
        let store = self.graph.store;
        let nodes = &self.graph.nodes;
        match formula {
            Ctl::True => Ok(nodes.clone()),
            Ctl::False => Ok(store.never()),
            Ctl::Atom(atom) => match self.atoms.get(*atom) {
                Some(set) => store.and(set, nodes),
                None => Ok(store.never()),
            },
            Ctl::Not(of) => self.not(&self.holds(of)?),
            Ctl::And(parts) => {
                let mut all = nodes.clone();
                for part in parts {
                    all = store.and(&all, &self.holds(part)?)?;
                }
                Ok(all)
            }
            Ctl::Or(parts) => {
                let mut any = store.never();
                for part in parts {
                    any = store.or(&any, &self.holds(part)?)?;
                }
                Ok(any)
            }
            Ctl::Implies(left, right) => {
                store.or(&self.not(&self.holds(left)?)?, &self.holds(right)?)
            }
            Ctl::Iff(left, right) => {
                let same = store.same(&self.holds(left)?, &self.holds(right)?)?;
                store.and(&same, nodes)
            }
            Ctl::Ex(steps, of) => self.repeated(*steps, self.holds(of)?),
            Ctl::Ax(steps, of) => {
                let not = self.not(&self.holds(of)?)?;
                self.not(&self.repeated(*steps, not)?)
            }
            Ctl::Ef(of) => self.until(nodes, &self.holds(of)?),
            Ctl::Af(of) => {
                let not = self.not(&self.holds(of)?)?;
                self.not(&self.graph.globally(&not)?)
            }
            Ctl::Eg(of) => self.graph.globally(&self.holds(of)?),
            Ctl::Ag(of) => {
                let not = self.not(&self.holds(of)?)?;
                self.not(&self.until(nodes, &not)?)
            }
            Ctl::Eu(left, right) => self.until(&self.holds(left)?, &self.holds(right)?),
            Ctl::Ew(left, right) => self.weak_until(&self.holds(left)?, &self.holds(right)?),
            Ctl::Au(left, right) => {
                // ¬E[¬right W ¬left ∧ ¬right]
                let (left, right) = (self.holds(left)?, self.holds(right)?);
                let not_right = self.not(&right)?;
                let neither = store.without(&not_right, &left)?;
                self.not(&self.weak_until(&not_right, &neither)?)
            }
            Ctl::Aw(left, right) => {
                let (left, right) = (self.holds(left)?, self.holds(right)?);
                let not_right = self.not(&right)?;
                let neither = store.without(&not_right, &left)?;
                self.not(&self.until(&not_right, &neither)?)
            }
        }
    }
}
