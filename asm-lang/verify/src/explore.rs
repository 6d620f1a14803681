//! The result of an exploration: all states that a specification can reach, in breadth-first order.
//!
//! A *state* contains the locations that rules update. A *node* is a state together with the values of the inputs that
//! properties mention; without such inputs, each state is one node. The nodes of a state are consecutive.

use crate::decisions::{Decision, InputValue};
use crate::fair_moves::MovedSet;
use crate::parents::Parents;
use crate::reads::InputFunctions;
use crate::spill::{Spill, Table};
use crate::store::{StateStorage, StateStore};
use crate::transition::{ConditionTerm, MachineFault, TransitionSystem};
use asmotion_lang::Machine;
use asmotion_lang::hir::FunctionId;
use std::borrow::Cow;
use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Debug;

/// Limits of an exploration; `None` for no limit.
#[derive(Clone, Copy, Debug, Default)]
pub struct Limits {
    /// Number of states.
    pub states: Option<u64>,
    /// Number of steps from an initial state.
    pub depth: Option<u32>,
    /// Memory for states and transitions, in bytes.
    pub memory: Option<u64>,
    /// Number of elements that `extend` creates in a machine. States with more are not explored.
    pub reserve: Option<usize>,
}

/// Options of an exploration.
#[derive(Clone, Debug)]
pub(crate) struct ExplorationOptions {
    pub limits: Limits,
    /// `true` to keep the transitions.
    pub keeps_edges: bool,
    /// Number of threads.
    pub threads: usize,
    pub storage: StateStorage,
    /// The only conditions that matter, besides those that are assumed; locations on which they do not depend can be left out.
    pub cone: Option<BTreeSet<usize>>,
    /// `true` to explore one of several states that permutations of elements make of each other, where that makes no difference.
    pub symmetry: bool,
    /// `true` to explore steps that do not influence each other in one order, where that makes no difference.
    pub independent: bool,
}

/// The progress of an exploration.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Progress {
    /// Number of states found.
    pub states: u64,
    /// Number of states whose successors are known.
    pub explored: u64,
    /// Number of transitions found.
    pub transitions: u64,
    /// Number of steps from an initial state to the states that are being explored.
    pub depth: u32,
    /// Memory in use for states and transitions, in bytes.
    pub memory: u64,
}

/// The reason for which an exploration ended before all states were found.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Incomplete {
    /// The limit for states.
    States,
    /// The limit for steps.
    Depth,
    /// The limit for memory.
    Memory,
    /// The limit for elements that `extend` creates.
    Reserve,
    /// The caller.
    Stopped,
}

/// The reason for which a specification cannot be explored.
#[derive(Debug)]
pub(crate) enum ExplorationError {
    /// A step or a property reads an input whose values cannot be enumerated.
    Input(MachineFault),
    /// A step or the properties have too many alternatives in a state.
    Alternatives,
    /// The initial state cannot be computed.
    Initial(MachineFault),
    /// Data outside of memory cannot be written or read.
    Storage(String),
}

/// A step that fails.
#[derive(Debug)]
pub(crate) struct FoundFault {
    /// The node before the step.
    pub node: u32,
    pub decisions: Vec<Decision>,
    pub fault: MachineFault,
    /// Number of executions that fail in this way.
    pub count: u64,
}

/// Truth values, one for each node.
#[derive(Clone, Debug, Default)]
pub(crate) struct Truths {
    words: Vec<u64>,
    len: usize,
}

impl Truths {
    pub fn push(&mut self, truth: bool) {
        if self.len.is_multiple_of(64) {
            self.words.push(0);
        }
        if let Some(last) = self.words.last_mut() {
            *last |= u64::from(truth) << (self.len % 64);
        }
        self.len += 1;
    }

    /// Returns `true` if the value is false at all nodes.
    pub fn is_empty(&self) -> bool {
        self.words.iter().all(|word| *word == 0)
    }

    pub fn get(&self, node: u32) -> bool {
        let word = self.words.get(node as usize / 64);
        word.is_some_and(|word| word >> (node % 64) & 1 == 1)
    }
}

/// The conditions that are evaluated at each node.
#[derive(Clone, Debug, Default)]
pub(crate) struct Conditions {
    pub terms: Vec<ConditionTerm>,
    /// Indices of the conditions without which a node is not considered.
    pub assumed: Vec<usize>,
}

/// The progress of an exploration.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Reached {
    /// The node to explore next.
    pub node: u32,
    pub states: u64,
    /// Number of explored states.
    pub explored: u32,
    /// Memory in use besides that of the exploration, in bytes.
    pub memory: u64,
}

/// States that are stored as words.
pub(crate) trait WordStates: Debug {
    /// Returns the number of states.
    fn len(&self) -> usize;

    /// Returns the bytes of a state, as the system packs it.
    fn bytes(&self, state: u32) -> Vec<u8>;

    /// Returns the number of the state in which a machine is, or of the one that stands for it.
    fn number_of(&self, machine: &Machine) -> Option<u32>;

    /// Returns `true` if only fingerprints of states were stored.
    fn is_compact(&self) -> bool;

    /// Returns `true` if a state stands for those that a permutation of elements makes of it.
    fn is_symmetric(&self) -> bool;

    /// Returns the memory in use, in bytes.
    fn memory(&self) -> usize;
}

/// Everything that was found.
#[derive(Debug, Default)]
pub(crate) struct Exploration {
    pub states: StateStore,
    /// The states as words, in place of `states`; each is then one node, if there are no `first_nodes`.
    pub words: Option<Box<dyn WordStates>>,
    /// First node of each state.
    pub first_nodes: Table<u32>,
    /// State of each node.
    pub state_of: Table<u32>,
    /// Inputs of each node: an index into `inputs`.
    pub inputs_of: Table<u32>,
    pub inputs: Vec<Vec<InputValue>>,
    /// Memory that `inputs` take, in bytes, with the tables in which they are looked up.
    pub input_memory: usize,
    /// Predecessor of each node on a shortest path.
    pub parents: Parents,
    /// First node of each depth.
    pub levels: Vec<u32>,
    /// Truth values of the conditions.
    pub truths: Vec<Truths>,
    /// Number of nodes at which each condition is undef.
    pub undefined: Vec<u64>,
    /// Conditions whose evaluation fails, with the first fault.
    pub failed_terms: BTreeMap<usize, MachineFault>,
    /// Edges of each explored node: its end in `targets`.
    pub edge_ends: Table<u64>,
    pub targets: Table<u32>,
    /// Agents and rules that the step of each edge moves, as an index into `moved_sets`; empty without fairness of agents and
    /// rules.
    pub labels: Table<u32>,
    pub moved_sets: Vec<MovedSet>,
    pub keeps_edges: bool,
    /// Names of functions of which locations were left out.
    pub left_out: Vec<String>,
    /// Names of the domains whose elements were permuted.
    pub symmetric: Vec<String>,
    /// `true` if steps were left out because they lead to the same states in another order.
    pub has_left_out_steps: bool,
    /// Space for tables outside of memory, if there is one.
    pub spill: Option<Spill>,
    pub faults: Vec<FoundFault>,
    /// States in which no step changes anything; the first one, and their number.
    pub stuck: Vec<u32>,
    /// Nodes from which a step changes more than the environment, if it has a part of the state.
    pub moving: Truths,
    /// Number of initial nodes.
    pub initial: u32,
    /// Number of explored nodes.
    pub explored: u32,
    /// Executions of the step that update a location, and the initial states.
    pub transitions: u64,
    /// Nodes that an assumption excludes.
    pub excluded: u64,
    pub incomplete: Option<Incomplete>,
    /// Coverage counts of each machine.
    pub counts: Vec<Vec<u64>>,
}

impl Exploration {
    /// Returns an exploration that has found nothing yet.
    pub fn new(options: &ExplorationOptions, conditions: usize) -> Self {
        let spill = options.storage.spill();
        Self {
            states: StateStore::new(&options.storage),
            first_nodes: Table::new(spill),
            state_of: Table::new(spill),
            inputs_of: Table::new(spill),
            edge_ends: Table::new(spill),
            targets: Table::new(spill),
            labels: Table::new(spill),
            truths: vec![Truths::default(); conditions],
            undefined: vec![0; conditions],
            keeps_edges: options.keeps_edges,
            spill: spill.cloned(),
            ..Self::default()
        }
    }

    /// Returns `true` if only fingerprints of states were stored.
    pub fn is_compact(&self) -> bool {
        let words = self.words.as_ref();
        words.map_or_else(|| self.states.is_compact(), |words| words.is_compact())
    }

    /// Returns `true` if [`Exploration::state`] does not return every state: states are forgotten, or stand for others, too.
    pub fn stands_for_others(&self) -> bool {
        let words = self.words.as_ref();
        words.map_or_else(
            || self.states.is_compact(),
            |words| words.is_compact() || words.is_symmetric(),
        )
    }

    /// Returns the number of the state in which a system is, or of the one that stands for it. `packed` are its bytes.
    pub fn number_of<S: TransitionSystem>(&self, system: &S, packed: &[u8]) -> Option<u32> {
        match &self.words {
            Some(words) => words.number_of(system.machines().first()?),
            None => self.states.find(packed),
        }
    }

    /// Returns the number of a node's state.
    pub fn state_number(&self, node: u32) -> Option<u32> {
        match self.plain_words() {
            Some(_) => Some(node),
            None => self.state_of.get(node as usize),
        }
    }

    /// Returns an error if something that is stored outside of memory could not be written or read.
    pub fn check_storage(&self) -> Result<(), ExplorationError> {
        let failed = self.spill.as_ref().and_then(Spill::failed);
        failed.map_or(Ok(()), |error| Err(ExplorationError::Storage(error)))
    }

    /// Returns an exploration that found one path only: the bytes of a state and the known inputs, for each node.
    #[cfg(feature = "symbolic")]
    pub fn of_path(path: Vec<(Vec<u8>, Vec<InputValue>)>) -> Self {
        let mut found = Self::default();
        for (node, (state, inputs)) in path.into_iter().enumerate() {
            let node = node as u32;
            let (state, is_new) = found.states.add(&state).unwrap_or_default();
            if is_new {
                found.first_nodes.push(node);
            }
            found.state_of.push(state);
            found.inputs_of.push(node);
            found.inputs.push(inputs);
            found.parents.push(node.checked_sub(1));
        }
        found
    }

    /// Returns the states as words, if each is one node.
    fn plain_words(&self) -> Option<&dyn WordStates> {
        let words = self.words.as_deref();
        words.filter(|_| self.first_nodes.len() == 0)
    }

    /// Returns the number of nodes.
    pub fn nodes(&self) -> u32 {
        match self.plain_words() {
            Some(words) => words.len() as u32,
            None => self.state_of.len() as u32,
        }
    }

    /// Returns the number of states.
    pub fn state_count(&self) -> u64 {
        match &self.words {
            Some(words) => words.len() as u64,
            None => self.states.len() as u64,
        }
    }

    /// Adds a combination of inputs that was not known; returns its number.
    pub fn add_inputs(&mut self, inputs: Vec<InputValue>) -> u32 {
        // the vectors, the arguments of each input, and a copy as the key of a table
        self.input_memory += 2 * (32 + inputs.len() * (size_of::<InputValue>() + 32));
        self.inputs.push(inputs);
        self.inputs.len() as u32 - 1
    }

    /// Returns the inputs by which nodes of one state differ.
    pub fn told_apart(&self) -> InputFunctions {
        let inputs = self.inputs.iter().flatten();
        let function = |it: &InputValue| (it.machine, FunctionId(it.function.0));
        inputs.map(function).collect()
    }

    /// Returns the known inputs of a node.
    pub fn inputs(&self, node: u32) -> &[InputValue] {
        let inputs = self.inputs_of.get(node as usize);
        let inputs = inputs.and_then(|inputs| self.inputs.get(inputs as usize));
        inputs.map(Vec::as_slice).unwrap_or_default()
    }

    /// Returns the bytes of a node's state.
    pub fn state(&self, node: u32) -> Cow<'_, [u8]> {
        if let Some(words) = &self.words {
            let state = self.state_number(node).unwrap_or_default();
            return Cow::Owned(words.bytes(state));
        }
        let state = self.state_of.get(node as usize);
        state.map(|it| self.states.get(it)).unwrap_or_default()
    }

    /// Returns the nodes of a state.
    pub fn nodes_of(&self, state: u32) -> std::ops::Range<u32> {
        if self.plain_words().is_some() {
            return state..state + 1;
        }
        let at = state as usize;
        let from = self.first_nodes.get(at).unwrap_or_default();
        let to = self.first_nodes.get(at + 1);
        from..to.unwrap_or_else(|| self.nodes())
    }

    /// Returns the nodes of the state that a node belongs to.
    pub fn nodes_beside(&self, node: u32) -> std::ops::Range<u32> {
        let state = self.state_of.get(node as usize);
        self.nodes_of(state.unwrap_or(node))
    }

    /// Returns the shortest path from an initial node to a node, both included.
    pub fn path(&self, node: u32) -> Vec<u32> {
        let mut path = vec![node];
        let mut at = node;
        while let Some(parent) = self.parents.get(at) {
            path.push(parent);
            at = parent;
        }
        path.reverse();
        path
    }

    /// Returns the successors of a node in ascending order, with the labels of the transitions, if they are kept.
    pub fn labelled_successors(&self, node: u32) -> impl Iterator<Item = (u32, u32)> {
        let (start, end) = self.edges(node);
        (start..end).filter_map(|edge| {
            let label = self.labels.get(edge).unwrap_or_default();
            Some((self.targets.get(edge)?, label))
        })
    }

    /// Returns the successors of a node in ascending order, if transitions are kept.
    pub fn successors(&self, node: u32) -> impl Iterator<Item = u32> {
        let (start, end) = self.edges(node);
        (start..end).filter_map(|edge| self.targets.get(edge))
    }

    /// Returns the indices of the edges of a node, from the first one to that after the last one.
    fn edges(&self, node: u32) -> (usize, usize) {
        let at = node as usize;
        let end = self.edge_ends.get(at).unwrap_or(0) as usize;
        let start = at
            .checked_sub(1)
            .and_then(|before| self.edge_ends.get(before));
        (start.unwrap_or(0) as usize, end)
    }

    /// Returns the label of each successor, in the same order; none if edges have no labels.
    pub fn labels(&self, node: u32) -> impl Iterator<Item = u32> {
        let (start, end) = self.edges(node);
        (start..end).filter_map(|edge| self.labels.get(edge))
    }

    /// Returns the nodes at a distance from the initial nodes.
    pub fn level(&self, depth: usize) -> std::ops::Range<u32> {
        let start = self.levels.get(depth).copied();
        let end = self.levels.get(depth + 1).copied();
        let nodes = self.nodes();
        start.unwrap_or(nodes)..end.unwrap_or(nodes)
    }

    /// Notes whether a node of a state is stuck. A state is if all its nodes are, which are noted one after the other.
    pub fn rests(&mut self, node: u32, state: u32, rests: bool) {
        let first = self.nodes_of(state).start;
        let was_stuck = node == first || self.stuck.last() == Some(&state);
        if rests && was_stuck {
            if node == first {
                self.stuck.push(state);
            }
        } else if self.stuck.last() == Some(&state) {
            self.stuck.pop();
        }
    }

    /// Counts the states in which runs end for some inputs, because no step leads on. Transitions must be kept.
    pub fn ends(&self) -> u64 {
        let mut ends = 0;
        let mut node = 0;
        while node < self.nodes() {
            let mut beside = self.nodes_beside(node);
            node = beside.end;
            ends += u64::from(beside.any(|it| self.successors(it).next().is_none()));
        }
        ends
    }

    /// Returns the states from which nothing but the environment ever changes, in ascending order.
    pub fn stuck_for_ever(&self) -> Vec<u32> {
        let count = self.nodes() as usize;
        let mut before: Vec<Vec<u32>> = vec![Vec::new(); count];
        for node in 0..self.nodes() {
            for target in self.successors(node) {
                if let Some(before) = before.get_mut(target as usize) {
                    before.push(node);
                }
            }
        }
        let mut waiting: Vec<u32> = (0..self.nodes())
            .filter(|it| self.moving.get(*it))
            .collect();
        let mut lives = vec![false; count];
        while let Some(node) = waiting.pop() {
            let Some(lives) = lives.get_mut(node as usize).filter(|lives| !**lives) else {
                continue;
            };
            *lives = true;
            let before = before.get(node as usize);
            waiting.extend(before.into_iter().flatten());
        }
        let dies = |state: &u32| {
            let mut nodes = self.nodes_of(*state);
            !nodes.is_empty() && nodes.all(|node| lives.get(node as usize) == Some(&false))
        };
        (0..self.states.len() as u32).filter(dies).collect()
    }

    /// Returns the greatest number of steps on a shortest path.
    pub fn depth(&self) -> u32 {
        (self.levels.len() as u32).saturating_sub(1)
    }

    pub fn memory(&self) -> u64 {
        let per_node = self.state_of.memory() + self.inputs_of.memory();
        let words = self.truths.iter().map(|truths| truths.words.capacity() * 8);
        let edges = self.edge_ends.memory() + self.targets.memory() + self.labels.memory();
        let nodes = per_node + self.first_nodes.memory() + self.parents.memory();
        let own = nodes + edges + words.sum::<usize>() + self.input_memory;
        let words = self.words.as_ref().map_or(0, |words| words.memory());
        (own + self.states.memory() + words) as u64
    }

    /// Returns the limit that is reached before this node is explored, if any.
    pub fn limit(
        &self,
        limits: Limits,
        reached: Reached,
        proceed: &mut dyn FnMut(Progress) -> bool,
    ) -> Option<Incomplete> {
        let depth = self.depth();
        if limits.depth.is_some_and(|limit| depth >= limit) {
            return Some(Incomplete::Depth);
        }
        if limits.states.is_some_and(|limit| reached.states > limit) {
            return Some(Incomplete::States);
        }
        if !reached.node.is_multiple_of(256) {
            return None;
        }
        self.resource_limit(limits, reached, proceed)
    }

    /// Returns the limit of memory that is reached, or that the caller ends the exploration.
    pub fn resource_limit(
        &self,
        limits: Limits,
        reached: Reached,
        proceed: &mut dyn FnMut(Progress) -> bool,
    ) -> Option<Incomplete> {
        let Reached {
            states,
            explored,
            memory,
            ..
        } = reached;
        let depth = self.depth();
        let memory = memory + self.memory();
        if limits.memory.is_some_and(|limit| memory > limit) {
            return Some(Incomplete::Memory);
        }
        let progress = Progress {
            states,
            explored: explored.into(),
            transitions: self.transitions,
            depth,
            memory,
        };
        (!proceed(progress)).then_some(Incomplete::Stopped)
    }

    /// Records a step that fails.
    pub fn fault(
        &mut self,
        node: u32,
        decisions: Vec<Decision>,
        fault: MachineFault,
    ) -> Result<(), ExplorationError> {
        if fault.is_of_input() {
            return Err(ExplorationError::Input(fault));
        }
        if node == 0 && fault.step().is_some_and(|fault| fault.step == 0) {
            return Err(ExplorationError::Initial(fault));
        }
        if let Some(known) = self.faults.iter_mut().find(|it| it.fault.is_like(&fault)) {
            known.count += 1;
        } else {
            self.faults.push(FoundFault {
                node,
                decisions,
                fault,
                count: 1,
            });
        }
        Ok(())
    }
}
