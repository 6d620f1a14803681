//! Exploration: all states that a specification can reach, in breadth-first order.
//!
//! A *state* contains the locations that rules update. A *node* is a state together with the values of the inputs that
//! properties mention; without such inputs, each state is one node. The nodes of a state are consecutive.

use crate::decisions::{Decision, Decisions, InputValue, MAX_EXECUTIONS};
use crate::fair_moves::{self, CountsBefore, FairMoves, MovedSet};
use crate::store::StateStore;
use crate::transition::{ConditionTerm, MachineFault, TransitionSystem};
use asmotion_lang::Value;
use std::borrow::Cow;
use std::collections::{BTreeMap, HashMap};
use std::fmt::Debug;

/// Parent of an initial node.
pub(crate) const NO_PARENT: u32 = u32::MAX;

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

/// How far an exploration has come.
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

    /// Returns the memory in use, in bytes.
    fn memory(&self) -> usize;
}

/// Everything that was found.
#[derive(Debug, Default)]
pub(crate) struct Exploration {
    pub states: StateStore,
    /// The states as words, in place of `states`; each is then one node.
    pub words: Option<Box<dyn WordStates>>,
    /// First node of each state.
    pub first_nodes: Vec<u32>,
    /// State of each node.
    pub state_of: Vec<u32>,
    /// Inputs of each node: an index into `inputs`.
    pub inputs_of: Vec<u32>,
    pub inputs: Vec<Vec<InputValue>>,
    /// Predecessor of each node on a shortest path.
    pub parents: Vec<u32>,
    /// First node of each depth.
    pub levels: Vec<u32>,
    /// Truth values of the conditions.
    pub truths: Vec<Truths>,
    /// Number of nodes at which each condition is undef.
    pub undefined: Vec<u64>,
    /// Conditions whose evaluation fails, with the first fault.
    pub failed_terms: BTreeMap<usize, MachineFault>,
    /// Edges of each explored node: its end in `targets`.
    pub edge_ends: Vec<u64>,
    pub targets: Vec<u32>,
    /// What the step of each edge moves, as an index into `moved_sets`; empty if no fairness is due to agents and rules.
    pub labels: Vec<u32>,
    pub moved_sets: Vec<MovedSet>,
    pub keeps_edges: bool,
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
            found.parents.push(node.checked_sub(1).unwrap_or(NO_PARENT));
        }
        found
    }

    /// Returns the number of nodes.
    pub fn nodes(&self) -> u32 {
        match &self.words {
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

    /// Returns the known inputs of a node.
    pub fn inputs(&self, node: u32) -> &[InputValue] {
        let inputs = self.inputs_of.get(node as usize);
        let inputs = inputs.and_then(|inputs| self.inputs.get(*inputs as usize));
        inputs.map(Vec::as_slice).unwrap_or_default()
    }

    /// Returns the bytes of a node's state.
    pub fn state(&self, node: u32) -> Cow<'_, [u8]> {
        if let Some(words) = &self.words {
            return Cow::Owned(words.bytes(node));
        }
        let state = self.state_of.get(node as usize);
        let state = state.map(|state| self.states.get(*state));
        Cow::Borrowed(state.unwrap_or_default())
    }

    /// Returns the nodes of a state.
    pub fn nodes_of(&self, state: u32) -> std::ops::Range<u32> {
        if self.words.is_some() {
            return state..state + 1;
        }
        let at = state as usize;
        let from = self.first_nodes.get(at).copied().unwrap_or_default();
        let to = self.first_nodes.get(at + 1).copied();
        from..to.unwrap_or_else(|| self.nodes())
    }

    /// Returns the shortest path from an initial node to a node, both included.
    pub fn path(&self, node: u32) -> Vec<u32> {
        let mut path = vec![node];
        let mut at = node;
        while let Some(&parent) = self.parents.get(at as usize)
            && parent != NO_PARENT
        {
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
            let label = self.labels.get(edge).copied().unwrap_or_default();
            Some((*self.targets.get(edge)?, label))
        })
    }

    /// Returns the successors of a node in ascending order, if transitions are kept.
    pub fn successors(&self, node: u32) -> &[u32] {
        let (start, end) = self.edges(node);
        self.targets.get(start..end).unwrap_or_default()
    }

    /// Returns the indices of the edges of a node, from the first one to that after the last one.
    fn edges(&self, node: u32) -> (usize, usize) {
        let at = node as usize;
        let end = self.edge_ends.get(at).copied().unwrap_or(0) as usize;
        let start = at
            .checked_sub(1)
            .and_then(|before| self.edge_ends.get(before));
        (start.copied().unwrap_or(0) as usize, end)
    }

    /// Returns the label of each successor, in the same order; none if edges have no labels.
    pub fn labels(&self, node: u32) -> &[u32] {
        let (start, end) = self.edges(node);
        self.labels.get(start..end).unwrap_or_default()
    }

    /// Returns `true` if the steps with a label move the agent or rule with this index.
    pub fn moves(&self, label: u32, index: usize) -> bool {
        let set = self.moved_sets.get(label as usize);
        fair_moves::contains(set.copied().unwrap_or_default(), index)
    }

    /// Returns the nodes at a distance from the initial nodes.
    pub fn level(&self, depth: usize) -> std::ops::Range<u32> {
        let start = self.levels.get(depth).copied();
        let end = self.levels.get(depth + 1).copied();
        let nodes = self.nodes();
        start.unwrap_or(nodes)..end.unwrap_or(nodes)
    }

    /// Returns the states from which nothing but the environment ever changes, in ascending order.
    fn stuck_for_ever(&self) -> Vec<u32> {
        let count = self.nodes() as usize;
        let mut before: Vec<Vec<u32>> = vec![Vec::new(); count];
        for node in 0..self.nodes() {
            for target in self.successors(node) {
                if let Some(before) = before.get_mut(*target as usize) {
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
        let per_node =
            self.state_of.capacity() + self.inputs_of.capacity() + self.parents.capacity();
        let words = self.truths.iter().map(|truths| truths.words.capacity() * 8);
        let edges = self.edge_ends.capacity() * 8
            + self.targets.capacity() * 4
            + self.labels.capacity() * 4;
        let own = per_node * 4 + self.first_nodes.capacity() * 4 + edges + words.sum::<usize>();
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
        let Reached {
            node,
            states,
            explored,
            memory,
        } = reached;
        let depth = self.depth();
        if limits.depth.is_some_and(|limit| depth >= limit) {
            return Some(Incomplete::Depth);
        }
        if limits.states.is_some_and(|limit| states > limit) {
            return Some(Incomplete::States);
        }
        if !node.is_multiple_of(256) {
            return None;
        }
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

/// An exploration in progress.
pub(crate) struct Explorer<'a, S> {
    pub system: S,
    pub conditions: &'a Conditions,
    pub limits: Limits,
    fair: &'a FairMoves,
    counts: CountsBefore,
    /// Indices of the sets in `moved_sets`.
    known_labels: HashMap<MovedSet, u32>,
    found: Exploration,
    decisions: Decisions,
    /// Numbers of the combinations of inputs.
    known_inputs: HashMap<Vec<InputValue>, u32>,
    values: Vec<Value>,
    packed: Vec<u8>,
    /// Transitions of the node that is being explored, with their labels.
    edges: Vec<(u32, u32)>,
    /// State of the node that is being explored, and of its successor, without the environment.
    own_before: Vec<u8>,
    own: Vec<u8>,
    /// `true` if a part of the state belongs to the environment.
    has_surroundings: bool,
    /// `true` if a state was left out because of the elements in it.
    lacks_elements: bool,
    /// `true` if fairness refers to the labels of transitions.
    has_labels: bool,
}

impl<'a, S: TransitionSystem> Explorer<'a, S> {
    pub fn new(
        mut system: S,
        conditions: &'a Conditions,
        limits: Limits,
        keeps_edges: bool,
        fair: &'a FairMoves,
    ) -> Self {
        if fair.has_agents() {
            system.keep_candidates();
        }
        let count = conditions.terms.len();
        let has_surroundings = system.has_surroundings();
        // whether a state is stuck depends on the later steps of the environment
        let keeps_edges = keeps_edges || has_surroundings;
        let has_labels = keeps_edges && !(system.fairness().is_empty() && fair.is_empty());
        let found = Exploration {
            truths: vec![Truths::default(); count],
            undefined: vec![0; count],
            keeps_edges,
            ..Exploration::default()
        };
        Self {
            system,
            conditions,
            limits,
            fair,
            counts: CountsBefore::default(),
            known_labels: HashMap::new(),
            found,
            decisions: Decisions::default(),
            known_inputs: HashMap::new(),
            values: Vec::new(),
            packed: Vec::new(),
            edges: Vec::new(),
            has_labels,
            lacks_elements: false,
            own_before: Vec::new(),
            own: Vec::new(),
            has_surroundings,
        }
    }

    /// Explores all states. `proceed` is called now and then, and ends the exploration by returning `false`.
    pub fn run(
        mut self,
        proceed: &mut dyn FnMut(Progress) -> bool,
    ) -> Result<Exploration, ExplorationError> {
        self.begin()?;
        self.found.initial = self.found.nodes();
        self.found.levels.push(0);
        let mut node = 0;
        let mut level_end = self.found.nodes();
        while node < self.found.nodes() {
            if node == level_end {
                self.found.levels.push(node);
                level_end = self.found.nodes();
            }
            let reached = Reached {
                node,
                states: self.found.state_count(),
                explored: self.found.state_of.get(node as usize).copied().unwrap_or(0),
                memory: 0,
            };
            let limit = self.found.incomplete;
            let limit = limit.or_else(|| self.found.limit(self.limits, reached, proceed));
            if let Some(reason) = limit {
                self.found.incomplete = Some(reason);
                break;
            }
            self.expand(node)?;
            node += 1;
            self.found.explored = node;
        }
        if self.has_surroundings && self.found.incomplete.is_none() {
            self.found.stuck = self.found.stuck_for_ever();
        }
        if self.lacks_elements {
            self.found.incomplete = self.found.incomplete.or(Some(Incomplete::Reserve));
        }
        self.found.counts = self.system.counts();
        Ok(self.found)
    }

    /// Adds the initial states.
    fn begin(&mut self) -> Result<(), ExplorationError> {
        let mut before = Vec::new();
        self.system.pack(&mut before);
        self.decisions.restart();
        loop {
            if let Err(fault) = self.system.begin(&self.decisions) {
                return Err(if fault.is_of_input() {
                    ExplorationError::Input(fault)
                } else {
                    ExplorationError::Initial(fault)
                });
            }
            self.packed.clear();
            self.system.pack(&mut self.packed);
            let known = self.found.states.len();
            self.arrive(NO_PARENT)?;
            self.found.transitions += (self.found.states.len() - known) as u64;
            if !self.decisions.advance() {
                return Ok(());
            }
            self.system.restore(&before);
        }
    }

    /// Returns `true` if a machine has created more elements than permitted.
    fn exceeds_reserve(&self) -> bool {
        let limit = self.limits.reserve;
        limit.is_some_and(|limit| {
            let mut machines = self.system.machines().iter();
            machines.any(|machine| machine.naming().reserve.len() > limit)
        })
    }

    /// Finds the successors of a node.
    fn expand(&mut self, node: u32) -> Result<(), ExplorationError> {
        let inputs = self.found.inputs(node).to_vec();
        let state = self
            .found
            .state_of
            .get(node as usize)
            .copied()
            .unwrap_or_default();
        let bytes = self.found.state(node).into_owned();
        self.system.restore(&bytes);
        if self.system.has_ended() {
            self.finish(node, state, false);
            return Ok(());
        }
        self.decisions.restart();
        self.own_before.clear();
        self.system.pack_own(&mut self.own_before);
        let mut executions = 0;
        let mut rests = true;
        loop {
            executions += 1;
            if executions > MAX_EXECUTIONS {
                return Err(ExplorationError::Alternatives);
            }
            let can_revert = self.system.can_revert();
            self.fair.before(&self.system, &mut self.counts);
            match self.system.step(&self.decisions, &inputs) {
                Ok(_) if self.exceeds_reserve() => {
                    rests = false;
                    self.lacks_elements = true;
                }
                Ok(has_updates) => {
                    self.found.transitions += u64::from(has_updates);
                    self.packed.clear();
                    self.system.pack(&mut self.packed);
                    let reached = self.arrive(node)?;
                    rests &= if self.has_surroundings {
                        self.own.clear();
                        self.system.pack_own(&mut self.own);
                        self.own == self.own_before
                    } else {
                        reached == state
                    };
                }
                Err(fault) => {
                    rests = false;
                    self.found.fault(node, self.decisions.taken(), fault)?;
                }
            }
            if !self.decisions.advance() {
                break;
            }
            if can_revert {
                self.system.revert();
            } else {
                self.system.restore(&bytes);
            }
        }
        self.finish(node, state, rests);
        Ok(())
    }

    /// Adds the state in `packed`, in which the machine is, and its nodes. Returns its number.
    fn arrive(&mut self, parent: u32) -> Result<u32, ExplorationError> {
        let Some((state, is_new)) = self.found.states.add(&self.packed) else {
            self.found.incomplete = Some(Incomplete::States);
            return Ok(0);
        };
        if is_new {
            self.found.first_nodes.push(self.found.nodes());
            self.observe(state, parent)?;
        }
        if self.found.keeps_edges && parent != NO_PARENT {
            let is_changed = self.found.state_of.get(parent as usize) != Some(&state);
            let label = self.label(is_changed);
            let nodes = self.found.nodes_of(state);
            self.edges.extend(nodes.map(|node| (node, label)));
        }
        Ok(state)
    }

    /// Returns the label of the last step.
    fn label(&mut self, is_changed: bool) -> u32 {
        if !self.has_labels {
            return 0;
        }
        let moved = self.fair.moved(&self.system, &self.counts, is_changed);
        let found = &mut self.found;
        *self.known_labels.entry(moved).or_insert_with(|| {
            found.moved_sets.push(moved);
            found.moved_sets.len() as u32 - 1
        })
    }

    /// Evaluates the conditions in the current state, and adds a node for each combination of inputs that they read.
    fn observe(&mut self, state: u32, parent: u32) -> Result<(), ExplorationError> {
        if self.conditions.terms.is_empty() {
            self.node(state, 0, parent);
            return Ok(());
        }
        let decisions = Decisions::default();
        let mut combinations = 0;
        loop {
            combinations += 1;
            if combinations > MAX_EXECUTIONS {
                return Err(ExplorationError::Alternatives);
            }
            self.evaluate(&decisions)?;
            let is_true = |index: &usize| self.values.get(*index) == Some(&Value::Bool(true));
            if self.conditions.assumed.iter().all(is_true) {
                let inputs = self.inputs_number(decisions.read());
                for (index, value) in self.values.iter().enumerate() {
                    if let Some(truths) = self.found.truths.get_mut(index) {
                        truths.push(*value == Value::Bool(true));
                    }
                    if let Some(undefined) = self.found.undefined.get_mut(index) {
                        *undefined += u64::from(value.is_undef());
                    }
                }
                self.node(state, inputs, parent);
            } else {
                self.found.excluded += 1;
            }
            if !decisions.advance() {
                return Ok(());
            }
        }
    }

    /// Evaluates the conditions into `values`; one whose evaluation fails is undef.
    fn evaluate(&mut self, decisions: &Decisions) -> Result<(), ExplorationError> {
        self.values.clear();
        let terms = &self.conditions.terms;
        while self.values.len() < terms.len() {
            let rest = terms.get(self.values.len()..).unwrap_or_default();
            let done = self.system.evaluate(rest, decisions, &mut self.values);
            if let Err(fault) = done {
                if fault.is_of_input() {
                    return Err(ExplorationError::Input(fault));
                }
                let index = self.values.len();
                self.found.failed_terms.entry(index).or_insert(fault);
                self.values.push(Value::Undef);
            }
        }
        Ok(())
    }

    fn inputs_number(&mut self, inputs: Vec<InputValue>) -> u32 {
        if let Some(number) = self.known_inputs.get(&inputs) {
            return *number;
        }
        let number = self.found.inputs.len() as u32;
        self.found.inputs.push(inputs.clone());
        self.known_inputs.insert(inputs, number);
        number
    }

    fn node(&mut self, state: u32, inputs: u32, parent: u32) {
        let found = &mut self.found;
        found.state_of.push(state);
        found.inputs_of.push(inputs);
        found.parents.push(parent);
    }

    /// Ends the edges of a node, and notes whether its state is stuck.
    fn finish(&mut self, node: u32, state: u32, rests: bool) {
        let found = &mut self.found;
        if found.keeps_edges {
            self.edges.sort_unstable();
            self.edges.dedup();
            found
                .targets
                .extend(self.edges.iter().map(|(target, _)| target));
            if self.has_labels {
                found
                    .labels
                    .extend(self.edges.iter().map(|(_, label)| label));
            }
            self.edges.clear();
            found.edge_ends.push(found.targets.len() as u64);
        }
        if self.has_surroundings {
            found.moving.push(!rests);
            return;
        }
        // a state is stuck if it is so with all inputs
        let nodes = found.nodes_of(state);
        let was_stuck = node == nodes.start || found.stuck.last() == Some(&state);
        if rests && was_stuck {
            if node == nodes.start {
                found.stuck.push(state);
            }
        } else if found.stuck.last() == Some(&state) {
            found.stuck.pop();
        }
    }
}
