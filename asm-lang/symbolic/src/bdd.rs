//! Binary decision diagrams, with errors in place of panics, and with exact counting.

use crate::error::SymbolicError;
use crate::operations::{Connective, DiagramOperations, Interruption, InterruptionCheck};
use asmotion_lang::ir::Origin;
use oxidd::bdd::{BDDFunction, BDDManagerRef};
use oxidd::{BooleanFunction, Function, HasLevel, LevelNo, Manager, ManagerRef, Node, NodeID};
use rustc_hash::{FxHashMap, FxHashSet};
use std::cell::Cell;

/// Number of a Boolean variable; variables are ordered by it.
pub(crate) type BitIndex = u32;

/// A Boolean function.
#[derive(Clone, PartialEq, Eq)]
pub(crate) struct Bdd(BDDFunction);

/// A renaming of variables.
pub(crate) struct Renaming {
    /// The new variable of each one; those after the last one keep theirs.
    to: Vec<LevelNo>,
    /// Distinguishes the renamings of a store.
    number: u32,
}

/// The store of all functions.
pub(crate) struct BddStore<'a> {
    manager: BDDManagerRef,
    /// Asks the caller whether to go on, also while an operation runs.
    interruption_check: InterruptionCheck<'a>,
    /// Number of variables.
    width: Cell<u32>,
    /// Number of renamings.
    renamings: Cell<u32>,
    capacity: usize,
    /// Number of nodes from which on the manager removes unused functions by itself.
    high_water: usize,
    always: Bdd,
    never: Bdd,
}

/// Bytes for an inner node, with its part of the unique table.
pub(crate) const NODE_BYTES: u64 = 24;

/// Limit for the variables. Operations recurse once for each.
const MAX_BITS: u32 = 1 << 16;

/// Bytes of the stack that an operation takes at most for a variable.
const FRAME_BYTES: usize = 1 << 10;

/// Bytes for an entry of the cache of operations.
const CACHE_ENTRY_BYTES: u64 = 28;

impl<'a> BddStore<'a> {
    /// Creates a store that takes at most this memory, in bytes. `proceed` is called now and then with the number of nodes, and ends
    /// operations by returning `false`.
    pub fn new(memory: u64, proceed: &'a dyn Fn(usize) -> bool) -> Self {
        let memory = memory.clamp(4 << 20, 64 << 30);
        // a quarter for the cache of operations, rounded down to a power of two
        let entries = (memory / 4 / CACHE_ENTRY_BYTES).clamp(1 << 14, 1 << 20);
        let entries = 1_usize << entries.ilog2();
        let nodes = (memory / 4 * 3 / NODE_BYTES).clamp(1 << 16, u64::from(u32::MAX / 4));
        let capacity = nodes as usize;
        let manager = oxidd::bdd::new_manager(capacity, entries, 1);
        let (always, never) =
            manager.with_manager_shared(|it| (Bdd(BDDFunction::t(it)), Bdd(BDDFunction::f(it))));
        Self {
            manager,
            interruption_check: InterruptionCheck::new(proceed),
            width: Cell::new(0),
            renamings: Cell::new(0),
            capacity,
            high_water: capacity / 100 * 95,
            always,
            never,
        }
    }

    pub fn always(&self) -> Bdd {
        self.always.clone()
    }

    pub fn never(&self) -> Bdd {
        self.never.clone()
    }

    /// Adds variables after the existing ones; returns the number of the first.
    pub fn add_bits(&self, count: u32) -> Result<BitIndex, SymbolicError> {
        let width = self.width.get().saturating_add(count);
        if width > MAX_BITS {
            let construct = "a specification with this many locations and inputs";
            return Err(SymbolicError::unsupported(Origin::default(), construct));
        }
        self.width.set(width);
        let added = self.manager.with_manager_exclusive(|it| it.add_vars(count));
        Ok(added.start)
    }

    /// Returns `true` if there are many variables.
    pub fn is_wide(&self) -> bool {
        self.width.get() > MAX_BITS / 4
    }

    /// Returns the function that is true if the variable has this value.
    pub fn bit(&self, bit: BitIndex, value: bool) -> Result<Bdd, SymbolicError> {
        self.run(|| {
            let function = self.manager.with_manager_shared(|it| {
                if value {
                    BDDFunction::var(it, bit)
                } else {
                    BDDFunction::not_var(it, bit)
                }
            });
            Ok(function?)
        })
    }

    /// Returns the conjunction of variables, which stands for the set of them.
    pub fn bits(&self, bits: &[BitIndex]) -> Result<Bdd, SymbolicError> {
        let mut sorted = bits.to_vec();
        sorted.sort_unstable();
        let mut all = self.always();
        for bit in sorted.into_iter().rev() {
            all = self.and(&self.bit(bit, true)?, &all)?;
        }
        Ok(all)
    }

    /// Executes an operation. If it needs almost all of the memory, unused functions are removed and it is executed again.
    ///
    /// The manager has a thread that removes unused functions while an operation runs, from a number of nodes on. Whether an
    /// operation that reaches this number succeeds depends on the speed of that thread. It is therefore considered to have failed,
    /// so that every run comes to the same result.
    fn run(
        &self,
        operation: impl Fn() -> Result<BDDFunction, Interruption>,
    ) -> Result<Bdd, SymbolicError> {
        // the thread may still be busy with the attempt before the last one
        for _ in 0..3 {
            let collections = self.collections();
            let function = self.deep(&operation);
            let is_full = self.nodes() >= self.high_water || self.collections() != collections;
            match function {
                Ok(function) if !is_full => return Ok(Bdd(function)),
                Err(Interruption::Stopped) => return Err(SymbolicError::Stopped),
                Ok(_) | Err(Interruption::Memory) => self.collect(),
            }
        }
        Err(SymbolicError::Memory)
    }

    /// Executes a recursion over the variables with a sufficient stack.
    fn deep<T>(&self, recursion: impl FnOnce() -> T) -> T {
        let bytes = (self.width.get() as usize + 64) * FRAME_BYTES;
        stacker::maybe_grow(bytes, bytes * 2, recursion)
    }

    /// Asks whether to go on.
    ///
    /// # Errors
    /// The answer is no.
    pub fn check(&self) -> Result<(), SymbolicError> {
        let answer = self.interruption_check.ask(self.nodes());
        answer.map_err(|_| SymbolicError::Stopped)
    }

    /// Removes unused functions.
    fn collect(&self) {
        // excludes the thread of the manager, during whose collection another one does nothing
        self.manager.with_manager_exclusive(|it| it.gc());
    }

    /// Removes unused functions if there are many functions.
    pub fn tidy(&self) {
        if self.nodes() > self.capacity / 4 * 3 {
            self.collect();
        }
    }

    /// Returns the number of collections of unused functions so far.
    fn collections(&self) -> u64 {
        self.manager.with_manager_shared(|it| it.gc_count())
    }

    /// Returns the number of nodes of all functions.
    fn nodes(&self) -> usize {
        self.manager
            .with_manager_shared(|it| it.approx_num_inner_nodes())
    }

    /// Returns the memory in use for functions, in bytes.
    pub fn memory(&self) -> u64 {
        self.nodes() as u64 * NODE_BYTES
    }

    pub fn not(&self, of: &Bdd) -> Result<Bdd, SymbolicError> {
        self.run(|| {
            of.0.with_manager_shared(|manager, of| {
                let done = DiagramOperations::begin(manager, &self.interruption_check)?.not(of)?;
                Ok(BDDFunction::from_edge(manager, done))
            })
        })
    }

    fn connect(
        &self,
        connective: Connective,
        left: &Bdd,
        right: &Bdd,
    ) -> Result<Bdd, SymbolicError> {
        self.run(|| {
            left.0.with_manager_shared(|manager, left| {
                let right = right.0.as_edge(manager);
                let operations = DiagramOperations::begin(manager, &self.interruption_check)?;
                let done = operations.connect(connective, left, right)?;
                Ok(BDDFunction::from_edge(manager, done))
            })
        })
    }

    pub fn and(&self, left: &Bdd, right: &Bdd) -> Result<Bdd, SymbolicError> {
        self.connect(Connective::And, left, right)
    }

    pub fn or(&self, left: &Bdd, right: &Bdd) -> Result<Bdd, SymbolicError> {
        self.connect(Connective::Or, left, right)
    }

    /// Returns `left` without `right`.
    pub fn without(&self, left: &Bdd, right: &Bdd) -> Result<Bdd, SymbolicError> {
        self.connect(Connective::Without, right, left)
    }

    pub fn same(&self, left: &Bdd, right: &Bdd) -> Result<Bdd, SymbolicError> {
        self.connect(Connective::Same, left, right)
    }

    /// Returns the function that is true if `of` is for some values of the variables.
    pub fn exists(&self, of: &Bdd, bits: &Bdd) -> Result<Bdd, SymbolicError> {
        self.run(|| {
            of.0.with_manager_shared(|manager, of| {
                let bits = bits.0.as_edge(manager);
                let done = DiagramOperations::begin(manager, &self.interruption_check)?
                    .exists(of, bits)?;
                Ok(BDDFunction::from_edge(manager, done))
            })
        })
    }

    /// Returns `exists(and(left, right), bits)`.
    pub fn and_exists(&self, left: &Bdd, right: &Bdd, bits: &Bdd) -> Result<Bdd, SymbolicError> {
        self.run(|| {
            left.0.with_manager_shared(|manager, left| {
                let (right, bits) = (right.0.as_edge(manager), bits.0.as_edge(manager));
                let operations = DiagramOperations::begin(manager, &self.interruption_check)?;
                let done = operations.and_exists(left, right, bits)?;
                Ok(BDDFunction::from_edge(manager, done))
            })
        })
    }

    /// Returns the disjunction of functions.
    pub fn any<'b>(&self, all: impl IntoIterator<Item = &'b Bdd>) -> Result<Bdd, SymbolicError> {
        let mut any = self.never();
        for one in all {
            any = self.or(&any, one)?;
        }
        Ok(any)
    }

    /// Returns the renaming of each first variable to the second one.
    pub fn renaming(&self, pairs: &[(BitIndex, BitIndex)]) -> Renaming {
        let end = pairs.iter().map(|(from, _)| from + 1).max();
        let mut to: Vec<LevelNo> = (0..end.unwrap_or(0)).collect();
        for (from, bit) in pairs {
            if let Some(place) = to.get_mut(*from as usize) {
                *place = *bit;
            }
        }
        let number = self.renamings.get();
        self.renamings.set(number + 1);
        Renaming { to, number }
    }

    pub fn rename(&self, of: &Bdd, renaming: &Renaming) -> Result<Bdd, SymbolicError> {
        self.run(|| {
            of.0.with_manager_shared(|manager, of| {
                let operations = DiagramOperations::begin(manager, &self.interruption_check)?;
                let done = operations.rename(of, &renaming.to, renaming.number)?;
                Ok(BDDFunction::from_edge(manager, done))
            })
        })
    }

    /// Returns the number of assignments of these variables, in ascending order, for which the function is true; it depends on no
    /// other ones. `None` if the number exceeds 128 bits.
    pub fn count(&self, of: &Bdd, bits: &[BitIndex]) -> Option<u128> {
        let positions: FxHashMap<BitIndex, u32> = bits.iter().copied().zip(0_u32..).collect();
        let mut known = FxHashMap::default();
        let end = bits.len() as u32;
        let counted = self.deep(|| self.count_below(&of.0, &positions, end, &mut known));
        let (count, position) = counted?;
        scaled(count, position)
    }

    /// Returns the number of assignments of the variables from that of the function on, and the position of that variable.
    fn count_below(
        &self,
        of: &BDDFunction,
        positions: &FxHashMap<BitIndex, u32>,
        end: u32,
        known: &mut FxHashMap<NodeID, u128>,
    ) -> Option<(u128, u32)> {
        let Some((high, low)) = of.cofactors() else {
            return Some((u128::from(of.satisfiable()), end));
        };
        let position = *positions.get(&top(of)?)?;
        let id = id(of);
        if let Some(count) = known.get(&id) {
            return Some((*count, position));
        }
        let mut count = 0_u128;
        for part in [high, low] {
            let (inner, at) = self.count_below(&part, positions, end, known)?;
            count = count.checked_add(scaled(inner, at.checked_sub(position + 1)?)?)?;
        }
        known.insert(id, count);
        Some((count, position))
    }

    /// Returns the number of nodes of a function.
    pub fn size(&self, of: &Bdd) -> usize {
        self.deep(|| of.0.node_count())
    }

    /// Returns the variables on which a function depends, in ascending order.
    pub fn support(&self, of: &Bdd) -> Vec<BitIndex> {
        let mut seen: FxHashSet<NodeID> = FxHashSet::default();
        let mut bits = std::collections::BTreeSet::new();
        let mut rest = vec![of.0.clone()];
        while let Some(function) = rest.pop() {
            if let Some((high, low)) = function.cofactors()
                && seen.insert(id(&function))
            {
                bits.extend(top(&function));
                rest.extend([high, low]);
            }
        }
        bits.into_iter().collect()
    }
}

fn scaled(count: u128, bits: u32) -> Option<u128> {
    match count {
        0 => Some(0),
        _ => count.checked_mul(1_u128.checked_shl(bits)?),
    }
}

/// Returns the number of a function's node, which is unique while the function is referred to.
fn id(of: &BDDFunction) -> NodeID {
    of.with_manager_shared(|_, edge| edge.node_id())
}

/// Returns the first variable on which a function depends.
fn top(of: &BDDFunction) -> Option<BitIndex> {
    // variables are never reordered: a level is a variable
    of.with_manager_shared(|manager, edge| match manager.get_node(edge) {
        Node::Inner(node) => Some(node.level()),
        Node::Terminal(_) => None,
    })
}

impl Bdd {
    /// Returns `true` if the function is nowhere true.
    pub fn is_never(&self) -> bool {
        !self.0.satisfiable()
    }

    /// Returns `true` if the function is true everywhere.
    pub fn is_always(&self) -> bool {
        self.0.valid()
    }

    /// Returns the value for an assignment, in which other variables are false.
    pub fn holds(&self, bits: &[(BitIndex, bool)]) -> bool {
        self.0.eval(bits.iter().copied())
    }
}
