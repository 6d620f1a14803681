//! Operations on diagrams that can be ended while they run.
//!
//! Those of `oxidd` run to their end, and a single one can take minutes and gigabytes: an image computation visits pairs of nodes. These
//! are the same recursions (Bryant 1986; Burch, Clarke et al. 1994 for the relational product) over the same nodes and the same cache of
//! results, and ask now and then whether to go on. What an ended operation has found remains in the cache and is right.

use oxidd_core::error::OutOfMemory;
use oxidd_core::util::{EdgeDropGuard, Own, Ref};
use oxidd_core::{
    ApplyCache, HasApplyCache, HasLevel, InnerNode, LevelNo, LevelView, Manager, Node,
};
use oxidd_rules_bdd::simple::{BDDOp, BDDTerminal};
use std::borrow::Borrow;
use std::cell::Cell;

/// Number of recursions, each of which visits a few nodes, between two questions whether to go on: some milliseconds.
const INTERVAL: u32 = 1 << 16;

/// Number of recursions that an operation counts for at least, so that many small ones ask as well.
const OPERATION: u32 = 16;

/// The managers of diagrams without complemented edges.
pub(crate) trait Diagrams:
    Manager<Terminal = BDDTerminal, InnerNode: HasLevel> + HasApplyCache<Self, BDDOp>
{
}

impl<M> Diagrams for M where
    M: Manager<Terminal = BDDTerminal, InnerNode: HasLevel> + HasApplyCache<M, BDDOp>
{
}

/// A reference to a node that is counted.
type OwnEdge<M> = Own<<M as Manager>::Edge>;

/// A borrowed reference to a node.
type Edge<'e, M> = Ref<'e, <M as Manager>::Edge>;

/// The reason for which an operation has no result.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Interruption {
    /// The memory is full.
    Memory,
    /// The caller ended it.
    Stopped,
}

impl From<OutOfMemory> for Interruption {
    fn from(_: OutOfMemory) -> Self {
        Self::Memory
    }
}

/// Counts recursions, and asks the caller whether to go on.
pub(crate) struct InterruptionCheck<'a> {
    left: Cell<u32>,
    proceed: &'a dyn Fn(usize) -> bool,
}

impl<'a> InterruptionCheck<'a> {
    /// Asks `proceed`, which receives the number of nodes of all functions.
    pub fn new(proceed: &'a dyn Fn(usize) -> bool) -> Self {
        Self {
            left: Cell::new(INTERVAL),
            proceed,
        }
    }

    /// Asks at once.
    pub fn ask(&self, nodes: usize) -> Result<(), Interruption> {
        self.left.set(INTERVAL);
        if (self.proceed)(nodes) {
            Ok(())
        } else {
            Err(Interruption::Stopped)
        }
    }

    fn spend<M: Manager>(&self, manager: &M, recursions: u32) -> Result<(), Interruption> {
        match self.left.get().checked_sub(recursions) {
            Some(left) => {
                self.left.set(left);
                Ok(())
            }
            None => self.ask(manager.approx_num_inner_nodes()),
        }
    }
}

/// A binary connective.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(crate) enum Connective {
    And,
    Or,
    /// The second operand without the first one.
    Without,
    Same,
}

impl Connective {
    fn code(self) -> BDDOp {
        match self {
            Self::And => BDDOp::And,
            Self::Or => BDDOp::Or,
            Self::Without => BDDOp::ImpStrict,
            Self::Same => BDDOp::Equiv,
        }
    }
}

/// The result of a connective, as far as it needs no recursion.
enum Settled<'e, M: Manager> {
    Constant(bool),
    Operand(Edge<'e, M>),
    Negation(Edge<'e, M>),
    /// Not settled: the operands, ordered if that makes no difference.
    Open(Edge<'e, M>, Edge<'e, M>),
}

/// The operations of a manager.
pub(crate) struct DiagramOperations<'a, M: Manager> {
    manager: &'a M,
    interruption_check: &'a InterruptionCheck<'a>,
}

impl<'a, M: Diagrams> DiagramOperations<'a, M> {
    /// Begins an operation.
    pub fn begin(
        manager: &'a M,
        interruption_check: &'a InterruptionCheck<'a>,
    ) -> Result<Self, Interruption> {
        interruption_check.spend(manager, OPERATION)?;
        Ok(Self {
            manager,
            interruption_check,
        })
    }

    fn constant(&self, value: bool) -> Result<OwnEdge<M>, Interruption> {
        let terminal = if value {
            BDDTerminal::True
        } else {
            BDDTerminal::False
        };
        Ok(self.manager.get_terminal(terminal)?)
    }

    /// Returns the value of a constant function.
    fn value(&self, of: Edge<'_, M>) -> Option<bool> {
        match self.manager.get_node(of) {
            Node::Inner(_) => None,
            Node::Terminal(terminal) => Some(*terminal.borrow() == BDDTerminal::True),
        }
    }

    /// Returns the level of a function's first variable; that of a constant is greater than all.
    fn level(&self, of: Edge<'_, M>) -> LevelNo {
        self.manager.get_node(of).level()
    }

    /// Returns the functions for a variable that is true or false, which is not after the first one.
    fn cofactors<'e>(&'e self, of: Edge<'e, M>, level: LevelNo) -> (Edge<'e, M>, Edge<'e, M>) {
        match self.manager.get_node(of) {
            Node::Inner(node) if node.level() == level => (node.child(0), node.child(1)),
            Node::Inner(_) | Node::Terminal(_) => (of, of),
        }
    }

    /// Returns a reference that is dropped if an error occurs before it is used.
    fn guard(&self, edge: OwnEdge<M>) -> EdgeDropGuard<'a, M> {
        EdgeDropGuard::new(self.manager, edge)
    }

    /// Returns the node with these children.
    fn node(
        &self,
        level: LevelNo,
        high: EdgeDropGuard<'_, M>,
        low: EdgeDropGuard<'_, M>,
    ) -> Result<OwnEdge<M>, Interruption> {
        if *high == *low {
            return Ok(high.into_edge());
        }
        let children = [high.into_edge(), low.into_edge()];
        let node = M::InnerNode::new(level, children);
        Ok(self.manager.level(level).get_or_insert(node)?)
    }

    fn known(&self, operator: BDDOp, operands: &[Edge<'_, M>]) -> Option<OwnEdge<M>> {
        let cache = self.manager.apply_cache();
        cache.get(self.manager, operator, operands)
    }

    fn note(&self, operator: BDDOp, operands: &[Edge<'_, M>], result: &OwnEdge<M>) {
        let cache = self.manager.apply_cache();
        cache.add(self.manager, operator, operands, result.borrowed());
    }

    pub fn not(&self, of: Edge<'_, M>) -> Result<OwnEdge<M>, Interruption> {
        if let Some(value) = self.value(of) {
            return self.constant(!value);
        }
        if let Some(known) = self.known(BDDOp::Not, &[of]) {
            return Ok(known);
        }
        self.interruption_check.spend(self.manager, 1)?;
        let level = self.level(of);
        let (high, low) = self.cofactors(of, level);
        let high = self.guard(self.not(high)?);
        let low = self.guard(self.not(low)?);
        let result = self.node(level, high, low)?;
        self.note(BDDOp::Not, &[of], &result);
        Ok(result)
    }

    fn settled<'e>(
        &self,
        connective: Connective,
        left: Edge<'e, M>,
        right: Edge<'e, M>,
    ) -> Settled<'e, M> {
        use Connective::{And, Or, Same, Without};
        let values = (self.value(left), self.value(right));
        match (connective, values) {
            (And | Or, _) if left == right => Settled::Operand(left),
            (Without, _) if left == right => Settled::Constant(false),
            (Same, _) if left == right => Settled::Constant(true),
            (And, (Some(false), _) | (_, Some(false))) => Settled::Constant(false),
            (Or, (Some(true), _) | (_, Some(true))) => Settled::Constant(true),
            (And | Or, (Some(_), _)) => Settled::Operand(right),
            (And | Or, (_, Some(_))) => Settled::Operand(left),
            (Without, (Some(true), _) | (_, Some(false))) => Settled::Constant(false),
            (Without, (Some(false), _)) | (Same, (Some(true), _)) => Settled::Operand(right),
            (Same, (_, Some(true))) => Settled::Operand(left),
            (Without, (_, Some(true))) | (Same, (_, Some(false))) => Settled::Negation(left),
            (Same, (Some(false), _)) => Settled::Negation(right),
            (Without, (None, None)) => Settled::Open(left, right),
            (And | Or | Same, (None, None)) => Settled::Open(left.min(right), left.max(right)),
        }
    }

    /// Returns the function that a connective makes of two.
    pub fn connect(
        &self,
        connective: Connective,
        left: Edge<'_, M>,
        right: Edge<'_, M>,
    ) -> Result<OwnEdge<M>, Interruption> {
        let (left, right) = match self.settled(connective, left, right) {
            Settled::Constant(value) => return self.constant(value),
            Settled::Operand(operand) => return Ok(self.manager.clone_edge(operand)),
            Settled::Negation(operand) => return self.not(operand),
            Settled::Open(left, right) => (left, right),
        };
        let operator = connective.code();
        if let Some(known) = self.known(operator, &[left, right]) {
            return Ok(known);
        }
        self.interruption_check.spend(self.manager, 1)?;
        let level = self.level(left).min(self.level(right));
        let (left_high, left_low) = self.cofactors(left, level);
        let (right_high, right_low) = self.cofactors(right, level);
        let high = self.guard(self.connect(connective, left_high, right_high)?);
        let low = self.guard(self.connect(connective, left_low, right_low)?);
        let result = self.node(level, high, low)?;
        self.note(operator, &[left, right], &result);
        Ok(result)
    }

    /// Returns the variables of a set, a conjunction, from a level on.
    fn below_level<'e>(&'e self, bits: Edge<'e, M>, level: LevelNo) -> Edge<'e, M> {
        let mut bits = bits;
        while let Node::Inner(node) = self.manager.get_node(bits)
            && node.level() < level
        {
            bits = node.child(0);
        }
        bits
    }

    /// Returns the function that is true if `of` is for some values of the variables.
    pub fn exists(&self, of: Edge<'_, M>, bits: Edge<'_, M>) -> Result<OwnEdge<M>, Interruption> {
        let level = self.level(of);
        let bits = self.below_level(bits, level);
        if self.value(of).is_some() || self.value(bits).is_some() {
            return Ok(self.manager.clone_edge(of));
        }
        if let Some(known) = self.known(BDDOp::Exists, &[of, bits]) {
            return Ok(known);
        }
        self.interruption_check.spend(self.manager, 1)?;
        let is_quantified = self.level(bits) == level;
        let (high, low) = self.cofactors(of, level);
        let high = self.guard(self.exists(high, bits)?);
        let low = self.guard(self.exists(low, bits)?);
        let result = if is_quantified {
            self.connect(Connective::Or, high.borrowed(), low.borrowed())?
        } else {
            self.node(level, high, low)?
        };
        self.note(BDDOp::Exists, &[of, bits], &result);
        Ok(result)
    }

    /// Returns the relational product: `exists(and(left, right), bits)`.
    pub fn and_exists(
        &self,
        left: Edge<'_, M>,
        right: Edge<'_, M>,
        bits: Edge<'_, M>,
    ) -> Result<OwnEdge<M>, Interruption> {
        let (left, right) = match self.settled(Connective::And, left, right) {
            Settled::Constant(value) => return self.constant(value),
            Settled::Operand(operand) | Settled::Negation(operand) => {
                return self.exists(operand, bits);
            }
            Settled::Open(left, right) => (left, right),
        };
        let level = self.level(left).min(self.level(right));
        let bits = self.below_level(bits, level);
        if self.value(bits).is_some() {
            return self.connect(Connective::And, left, right);
        }
        if let Some(known) = self.known(BDDOp::ExistsAnd, &[left, right, bits]) {
            return Ok(known);
        }
        self.interruption_check.spend(self.manager, 1)?;
        let is_quantified = self.level(bits) == level;
        let (left_high, left_low) = self.cofactors(left, level);
        let (right_high, right_low) = self.cofactors(right, level);
        let high = self.guard(self.and_exists(left_high, right_high, bits)?);
        let result = if is_quantified && self.value(high.borrowed()) == Some(true) {
            high.into_edge()
        } else {
            let low = self.guard(self.and_exists(left_low, right_low, bits)?);
            if is_quantified {
                self.connect(Connective::Or, high.borrowed(), low.borrowed())?
            } else {
                self.node(level, high, low)?
            }
        };
        self.note(BDDOp::ExistsAnd, &[left, right, bits], &result);
        Ok(result)
    }

    /// Returns a function with other variables: `to` has the new level of each level, as far as it goes, and `number` is its own.
    pub fn rename(
        &self,
        of: Edge<'_, M>,
        to: &[LevelNo],
        number: u32,
    ) -> Result<OwnEdge<M>, Interruption> {
        let level = self.level(of);
        let cache = self.manager.apply_cache();
        if self.value(of).is_some() || level as usize >= to.len() {
            return Ok(self.manager.clone_edge(of));
        }
        let known = cache.get_extended(self.manager, BDDOp::Substitute, (&[of], &[number]));
        if let Some(([known], [])) = known {
            return Ok(known);
        }
        self.interruption_check.spend(self.manager, 1)?;
        let (high, low) = self.cofactors(of, level);
        let high = self.guard(self.rename(high, to, number)?);
        let low = self.guard(self.rename(low, to, number)?);
        let level = to.get(level as usize).copied().unwrap_or(level);
        let below = self.level(high.borrowed()).min(self.level(low.borrowed()));
        let result = if level < below {
            self.node(level, high, low)?
        } else {
            self.choice(level, &high, &low)?
        };
        let values: (&[Edge<'_, M>], &[u32]) = (&[result.borrowed()], &[]);
        cache.add_extended(self.manager, BDDOp::Substitute, (&[of], &[number]), values);
        Ok(result)
    }

    /// Returns `high` where a variable is true, and `low` where it is false.
    fn choice(
        &self,
        level: LevelNo,
        high: &OwnEdge<M>,
        low: &OwnEdge<M>,
    ) -> Result<OwnEdge<M>, Interruption> {
        let (yes, no) = (
            self.guard(self.constant(true)?),
            self.guard(self.constant(false)?),
        );
        let variable = self.guard(self.node(level, yes, no)?);
        let high = self.connect(Connective::And, variable.borrowed(), high.borrowed())?;
        let high = self.guard(high);
        let low = self.connect(Connective::Without, variable.borrowed(), low.borrowed())?;
        let low = self.guard(low);
        self.connect(Connective::Or, high.borrowed(), low.borrowed())
    }
}
