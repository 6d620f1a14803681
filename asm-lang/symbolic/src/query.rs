//! Questions about the states that were reached.

use crate::bdd::Bdd;
use crate::branching::Branching;
use crate::error::SymbolicError;
use crate::fault::FaultClass;
use crate::fixpoints::{FairSet, Fixpoints};
use crate::linear::Tableau;
use crate::model::{NodeSet, SymbolicModel};
use crate::reach::Reached;
use asmotion_lang::Value;
use asmotion_lang::ir::{FunctionId, Origin, Slot};
use asmotion_temporal::{Ctl, FairPaths, Ltl};

/// A fairness constraint over sets of nodes.
pub enum SymbolicFairness {
    /// Infinitely often in the set.
    Justice(NodeSet),
    /// If infinitely often in the first set, then infinitely often in the second.
    Compassion(NodeSet, NodeSet),
}

/// A temporal formula whose atoms are conditions.
pub enum SymbolicFormula<'f> {
    /// Branching time.
    Ctl(&'f Ctl),
    /// Linear time.
    Ltl(&'f Ltl),
}

/// The result of checking a temporal formula.
pub struct SymbolicVerdict {
    /// The initial nodes in which it is violated.
    pub violated: NodeSet,
    /// The initial nodes from which fair paths start.
    pub fair: FairPaths,
}

/// Numbers about the states that were reached; `None` if a number exceeds 64 bits.
pub struct ReachedCounts {
    /// Number of states.
    pub states: Option<u64>,
    /// Number of executions of the step that update a location, and of initial states.
    pub transitions: Option<u64>,
    /// Number of combinations of a state and inputs that the assumptions exclude.
    pub excluded: Option<u64>,
}

/// The faults of one kind at one place.
pub struct SymbolicFault {
    /// The rule or term that fails.
    pub origin: Origin,
    /// The kind of the fault.
    pub class: FaultClass,
    /// The nodes in which a step can fail in this way.
    pub nodes: NodeSet,
    /// The nodes with the inputs and choices of such a step.
    pub(crate) cases: Bdd,
}

impl SymbolicModel<'_> {
    /// Returns the memory in use for diagrams, in bytes.
    pub fn memory(&self) -> u64 {
        self.store.memory()
    }

    fn or(&self, sets: &[&NodeSet]) -> Result<NodeSet, SymbolicError> {
        self.store.any(sets.iter().map(|it| &it.0)).map(NodeSet)
    }

    /// Returns the reached nodes in which a condition is true.
    ///
    /// # Errors
    /// The memory is full, or the caller ended it.
    pub fn condition(&self, reached: &Reached, index: usize) -> Result<NodeSet, SymbolicError> {
        match self.conditions.get(index) {
            Some(condition) => self.store.and(&condition.yes, &reached.nodes).map(NodeSet),
            None => Ok(NodeSet(self.store.never())),
        }
    }

    /// Returns the reached nodes.
    pub fn all(&self, reached: &Reached) -> NodeSet {
        NodeSet(reached.nodes.clone())
    }

    /// Returns the reached nodes outside a set.
    ///
    /// # Errors
    /// The memory is full, or the caller ended it.
    pub fn complement(&self, reached: &Reached, set: &NodeSet) -> Result<NodeSet, SymbolicError> {
        self.store.without(&reached.nodes, &set.0).map(NodeSet)
    }

    /// Returns the nodes in both sets.
    ///
    /// # Errors
    /// The memory is full, or the caller ended it.
    pub fn intersection(&self, left: &NodeSet, right: &NodeSet) -> Result<NodeSet, SymbolicError> {
        self.store.and(&left.0, &right.0).map(NodeSet)
    }

    /// Returns the nodes in one of the sets.
    ///
    /// # Errors
    /// The memory is full, or the caller ended it.
    pub fn union(&self, left: &NodeSet, right: &NodeSet) -> Result<NodeSet, SymbolicError> {
        self.or(&[left, right])
    }

    /// Returns the number of nodes at which a condition is undef, and `true` if its evaluation fails somewhere.
    ///
    /// # Errors
    /// The memory is full, or the caller ended it.
    pub fn undefined(&self, reached: &Reached, index: usize) -> Result<(u64, bool), SymbolicError> {
        let Some(condition) = self.conditions.get(index) else {
            return Ok((0, false));
        };
        let undef = self.store.or(&condition.undef, &condition.fails)?;
        let undef = self.store.and(&undef, &reached.nodes)?;
        let cases = self.store.and(&self.consistent, &reached.states)?;
        let fails = self.store.and(&condition.fails, &cases)?;
        let count = self
            .node_count(&undef)
            .and_then(|it| u64::try_from(it).ok());
        Ok((count.unwrap_or(u64::MAX), !fails.is_never()))
    }

    /// Returns the reached nodes in which the evaluation of a condition fails.
    ///
    /// # Errors
    /// The memory is full, or the caller ended it.
    pub fn failing(&self, reached: &Reached, index: usize) -> Result<NodeSet, SymbolicError> {
        match self.conditions.get(index) {
            Some(condition) => self
                .store
                .and(&condition.fails, &reached.nodes)
                .map(NodeSet),
            None => Ok(NodeSet(self.store.never())),
        }
    }

    /// Counts states and transitions.
    ///
    /// # Errors
    /// The memory is full, or the caller ended it.
    pub fn counts(&self, reached: &Reached) -> Result<ReachedCounts, SymbolicError> {
        let narrow = |count: Option<u128>| count.and_then(|it| u64::try_from(it).ok());
        let mut transitions = Some(1_u128);
        for moves in &self.moves {
            let executions = moves.executions(&self.store, &reached.nodes)?;
            let mut bits = self.node_bits();
            bits.extend_from_slice(&moves.decided);
            bits.sort_unstable();
            let count = self.store.count(&executions, &bits);
            transitions = transitions
                .zip(count)
                .and_then(|(sum, count)| sum.checked_add(count));
        }
        let cases = self.store.and(&self.consistent, &reached.states)?;
        let excluded = self.store.without(&cases, &self.valid)?;
        Ok(ReachedCounts {
            states: narrow(self.state_count(&reached.states)),
            transitions: narrow(transitions),
            excluded: narrow(self.node_count(&excluded)),
        })
    }

    /// Returns the faults that steps from the reached nodes can have.
    ///
    /// # Errors
    /// The memory is full, or the caller ended it.
    pub fn faults(&self, reached: &Reached) -> Result<Vec<SymbolicFault>, SymbolicError> {
        let mut found = Vec::new();
        for fault in &self.faults {
            let nodes = self.store.and(&fault.guard, &reached.nodes)?;
            if !nodes.is_never() {
                found.push(SymbolicFault {
                    origin: fault.origin,
                    class: fault.class,
                    nodes: NodeSet(self.only_nodes(&nodes)?),
                    cases: nodes,
                });
            }
        }
        Ok(found)
    }

    /// Removes the variables of inputs and choices that are no part of nodes.
    fn only_nodes(&self, set: &Bdd) -> Result<Bdd, SymbolicError> {
        let nodes = self.node_bits();
        let mut others = self.store.support(set);
        others.retain(|bit| nodes.binary_search(bit).is_err());
        self.store.exists(set, &self.store.bits(&others)?)
    }

    /// Returns the nodes of the states in which nothing changes, whatever the inputs and choices.
    ///
    /// # Errors
    /// The memory is full, or the caller ended it.
    pub fn stuck(&self, reached: &Reached) -> Result<NodeSet, SymbolicError> {
        let mut moving = self.store.never();
        let changes = self.moves.iter().map(|moves| &moves.changes);
        let fails = self.faults.iter().map(|fault| &fault.guard);
        for guard in changes.chain(fails) {
            let nodes = self.store.and(guard, &reached.nodes)?;
            moving = self.store.or(&moving, &self.only_nodes(&nodes)?)?;
        }
        let moving = self.states_of(&moving)?;
        self.store.without(&reached.nodes, &moving).map(NodeSet)
    }

    /// Counts the states in which runs end for some inputs, because no step leads on. `None` if there are more than 2^64 - 1. All
    /// states must be reached.
    ///
    /// # Errors
    /// The memory is full, or the caller ended it.
    pub fn ends(&self, reached: &Reached) -> Result<Option<u64>, SymbolicError> {
        let leaving = self.only_nodes(&self.before(&reached.nodes)?)?;
        let ends = self.store.without(&reached.nodes, &leaving)?;
        let count = self.state_count(&self.states_of(&ends)?);
        Ok(count.and_then(|it| u64::try_from(it).ok()))
    }

    /// Returns for each counted rule whether a step from a reached node runs it; other counters have no entry.
    ///
    /// # Errors
    /// The memory is full, or the caller ended it.
    pub fn executed(&self, reached: &Reached) -> Result<Vec<(u32, bool)>, SymbolicError> {
        let mut executed = Vec::new();
        for (counter, guard) in &self.counted {
            let nodes = self.store.and(guard, &reached.nodes)?;
            executed.push((*counter, !nodes.is_never()));
        }
        Ok(executed)
    }

    /// Checks a temporal formula in the initial nodes. All states must be reached.
    ///
    /// # Errors
    /// The memory is full, or the caller ended it.
    pub fn check(
        &self,
        reached: &Reached,
        formula: &SymbolicFormula<'_>,
        fairness: &[SymbolicFairness],
    ) -> Result<SymbolicVerdict, SymbolicError> {
        let nodes = &reached.nodes;
        let atoms: Vec<Bdd> = self.conditions.iter().map(|it| it.yes.clone()).collect();
        let fairness: Vec<FairSet> = fairness
            .iter()
            .map(|constraint| match constraint {
                SymbolicFairness::Justice(often) => FairSet::Justice(often.0.clone()),
                SymbolicFairness::Compassion(cause, effect) => {
                    FairSet::Compassion(cause.0.clone(), effect.0.clone())
                }
            })
            .collect();
        let leaving = self.before(nodes)?;
        let dead = self.store.without(nodes, &leaving)?;
        // a node from which no step leads on is its own successor
        let predecessors = |set: &Bdd| -> Result<Bdd, SymbolicError> {
            let stays = self.store.and(&dead, set)?;
            self.store.or(&self.before(set)?, &stays)
        };
        let graph = Fixpoints {
            store: &self.store,
            nodes: nodes.clone(),
            predecessors: &predecessors,
            fairness: &fairness,
        };
        let initial = self.store.and(&self.initial, nodes)?;
        let fair = graph.fair()?;
        let from = self.store.and(&initial, &fair)?;
        let paths = match (from.is_never(), from == initial) {
            (true, _) => FairPaths::FromNone,
            (false, true) => FairPaths::FromAll,
            (false, false) => FairPaths::FromSome,
        };
        let violated = match formula {
            SymbolicFormula::Ctl(formula) => {
                let branching = Branching {
                    graph,
                    atoms: &atoms,
                    fair,
                };
                let holds = branching.holds(formula)?;
                self.store.without(&from, &holds)?
            }
            SymbolicFormula::Ltl(formula) => {
                let mut tableau = Tableau::new(&self.store, &atoms);
                let not = Ltl::negation((*formula).clone());
                tableau.satisfying(&not, &initial, &graph)?
            }
        };
        Ok(SymbolicVerdict {
            violated: NodeSet(violated),
            fair: paths,
        })
    }

    /// Returns the reached nodes from which a step leads to a node of the set. Variables that are no part of nodes are kept.
    fn before(&self, set: &Bdd) -> Result<Bdd, SymbolicError> {
        let states = self.states_of(set)?;
        let mut found = self.store.never();
        for moves in &self.moves {
            let before = moves.predecessors(&self.store, &states)?;
            found = self.store.or(&found, &before)?;
        }
        Ok(found)
    }

    /// Returns the nodes on the shortest paths to a set: those after each number of steps. `None` if no reached node is in the set.
    ///
    /// # Errors
    /// The memory is full, or the caller ended it.
    pub fn shortest(
        &self,
        reached: &Reached,
        set: &NodeSet,
    ) -> Result<Option<Vec<NodeSet>>, SymbolicError> {
        for (depth, ring) in reached.rings.iter().enumerate() {
            let goal = self.intersection(ring, set)?;
            if goal.is_empty() {
                continue;
            }
            let mut path = vec![goal];
            for ring in reached.rings.iter().take(depth).rev() {
                if let Some(next) = path.last() {
                    let before = NodeSet(self.before(&next.0)?);
                    path.push(self.intersection(ring, &before)?);
                }
            }
            path.reverse();
            return Ok(Some(path));
        }
        Ok(None)
    }

    /// Returns `true` if a node is in a set. The node is given by the values of locations, and by those inputs that its conditions
    /// read.
    pub fn contains<'v>(
        &self,
        set: &NodeSet,
        value: &dyn Fn(Slot) -> Value,
        inputs: impl Iterator<Item = (FunctionId, &'v [Value], &'v Value)>,
    ) -> bool {
        let mut assignment = Vec::new();
        for (slot, code) in &self.slots {
            let Some(index) = code.index(&value(*slot)) else {
                return false;
            };
            code.now.assignment(index, &mut assignment);
        }
        let mut read: Vec<Option<usize>> = vec![None; self.inputs.all.len()];
        for (function, arguments, value) in inputs {
            let number = self.inputs.find(function, arguments);
            let known = number.and_then(|number| {
                let input = self.inputs.all.get(number)?;
                Some((number, input.values.iter().position(|it| it == value)?))
            });
            if let Some((number, index)) = known
                && let Some(place) = read.get_mut(number)
            {
                *place = Some(index);
            }
        }
        for (input, read) in self.inputs.all.iter().zip(read) {
            if let Some(known) = &input.known {
                let index = read.unwrap_or(input.values.len());
                known.assignment(index, &mut assignment);
            }
        }
        set.0.holds(&assignment)
    }
}
