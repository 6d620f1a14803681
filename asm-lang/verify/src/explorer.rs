//! Exploration in breadth-first order by any number of threads.
//!
//! Nodes are explored in rounds of consecutive nodes. The threads first execute the steps of the round's nodes, each with a system of
//! its own, and look up the states that they reach among those that are known; nothing that is known changes meanwhile. Then one thread
//! takes over what was found, in the order of the nodes and of the executions in them. Numbers of states and nodes, limits, the first
//! faults and the parents therefore depend neither on the number of threads nor on the sizes of rounds.

use crate::decisions::InputValue;
use crate::expansion::{
    Expander, Expansions, KnownStates, NodeSuccessors, NodeToExpand, ReachedState, StepOutcome,
};
use crate::explore::{
    Conditions, Exploration, ExplorationError, ExplorationOptions, Incomplete, Limits, Progress,
    Reached,
};
use crate::fair_moves::{FairMoves, MovedSet};
use crate::round_limits::{ExaminedLimits, RoundLimits};
use crate::transition::TransitionSystem;
use std::collections::HashMap;
use std::sync::atomic::{AtomicUsize, Ordering};

/// Number of executions of steps in a round for each thread, as far as it can be foreseen.
const ROUND_EXECUTIONS: u64 = 2048;

/// Greatest number of nodes in a round for each thread.
const ROUND_NODES: usize = 512;

/// Number of nodes that a thread takes at a time.
const PART_NODES: usize = 16;

/// Number of nodes from which a round is worth more than one thread.
const MIN_SHARED_NODES: usize = 32;

/// An exploration in progress.
pub(crate) struct Explorer<'a, S> {
    expander: Expander<'a, S>,
    /// Expanders of the other threads.
    others: Vec<Expander<'a, S>>,
    threads: usize,
    limits: Limits,
    /// Indices of the sets in `moved_sets`.
    known_labels: HashMap<MovedSet, u32>,
    found: Exploration,
    /// Numbers of the combinations of inputs.
    known_inputs: HashMap<Vec<InputValue>, u32>,
    /// Transitions of the node that is being explored, with their labels.
    edges: Vec<(u32, u32)>,
    /// `true` if a state was left out because of the elements in it.
    lacks_elements: bool,
    /// Number of nodes and executions of the last round.
    last_round: (u64, u64),
}

impl<'a, S: TransitionSystem> Explorer<'a, S> {
    pub fn new(
        mut system: S,
        conditions: &'a Conditions,
        options: &ExplorationOptions,
        fair: &'a FairMoves,
    ) -> Self {
        if fair.has_agents() {
            system.keep_candidates();
        }
        let count = conditions.terms.len();
        let limits = options.limits;
        // whether a state is stuck depends on the later steps of the environment
        let keeps_edges = options.keeps_edges || system.has_surroundings();
        let has_labels = keeps_edges && !(system.fairness().is_empty() && fair.is_empty());
        Self {
            expander: Expander::new(system, conditions, limits, fair, has_labels),
            others: Vec::new(),
            threads: options.threads.max(1),
            limits,
            known_labels: HashMap::new(),
            found: Exploration {
                keeps_edges,
                ..Exploration::new(options, count)
            },
            known_inputs: HashMap::new(),
            edges: Vec::new(),
            lacks_elements: false,
            last_round: (1, ROUND_EXECUTIONS),
        }
    }

    /// Explores all states. `proceed` is called now and then, and ends the exploration by returning `false`.
    pub fn run(
        mut self,
        proceed: &mut dyn FnMut(Progress) -> bool,
    ) -> Result<Exploration, ExplorationError> {
        let limits = RoundLimits::new(self.limits, self.progress(0));
        let mut examined = ExaminedLimits::new(&limits, Some(&mut *proceed));
        let mut initial = self.expander.begin(&mut examined)?;
        self.found.incomplete = limits.ended();
        let mut numbers = vec![None; initial.fresh.len()];
        for index in 0..initial.fresh.len() as u32 {
            self.enter(index, None, &mut initial, &mut numbers)?;
        }
        self.found.transitions = self.found.states.len() as u64;
        self.found.initial = self.found.nodes();
        self.found.levels.push(0);
        let mut node = 0;
        let mut level_end = self.found.nodes();
        while node < self.found.nodes() && self.found.incomplete.is_none() {
            let counts_before = self.counts();
            let limits = RoundLimits::new(self.limits, self.progress(node));
            let mut round = self.round(node, &limits, proceed);
            let first = node;
            self.found.incomplete = limits.ended();
            if self.found.incomplete.is_some() {
                // the successors of some nodes are missing
                round.clear();
            }
            for mut part in round {
                let mut numbers = vec![None; part.fresh.len()];
                for index in 0..part.nodes.len() {
                    if node == level_end {
                        self.found.levels.push(node);
                        level_end = self.found.nodes();
                    }
                    if let Some(reason) = self.limit(node, proceed) {
                        self.found.incomplete = Some(reason);
                        break;
                    }
                    let successors = part.nodes.get_mut(index).map(std::mem::take);
                    let successors = successors.unwrap_or_default();
                    self.take_over(node, successors, &mut part, &mut numbers)?;
                    node += 1;
                    self.found.explored = node;
                }
                if self.found.incomplete.is_some() {
                    break;
                }
            }
            if self.found.incomplete.is_some() {
                // what later nodes execute does not count
                self.found.counts = self.counts_up_to(first..node, counts_before);
            }
            self.found.check_storage()?;
            if let Some(state) = self.found.state_of.get(node as usize) {
                self.found.states.forget_before(state);
            }
        }
        if self.found.counts.is_empty() {
            self.found.counts = self.counts();
        }
        if self.expander.has_surroundings && self.found.incomplete.is_none() {
            self.found.stuck = self.found.stuck_for_ever();
        }
        if self.lacks_elements {
            self.found.incomplete = self.found.incomplete.or(Some(Incomplete::Reserve));
        }
        Ok(self.found)
    }

    /// Returns the progress before a node is explored.
    fn progress(&self, node: u32) -> Progress {
        let explored = self.found.state_of.get(node as usize).unwrap_or(0);
        Progress {
            states: self.found.state_count(),
            explored: explored.into(),
            transitions: self.found.transitions,
            depth: self.found.depth(),
            memory: self.found.memory(),
        }
    }

    fn limit(&self, node: u32, proceed: &mut dyn FnMut(Progress) -> bool) -> Option<Incomplete> {
        let reached = Reached {
            node,
            states: self.found.state_count(),
            explored: self.found.state_of.get(node as usize).unwrap_or(0),
            memory: 0,
        };
        let limit = self.found.incomplete;
        limit.or_else(|| self.found.limit(self.limits, reached, proceed))
    }

    /// Finds the successors of the nodes from this one on, as far as a round goes, in parts.
    fn round(
        &mut self,
        first: u32,
        limits: &RoundLimits,
        proceed: &mut dyn FnMut(Progress) -> bool,
    ) -> Vec<Expansions> {
        let waiting = (self.found.nodes() - first) as usize;
        let (nodes, executions) = self.last_round;
        let foreseen = (nodes * ROUND_EXECUTIONS).div_ceil(executions.max(1)) as usize;
        let size = foreseen.clamp(1, ROUND_NODES);
        let is_shared = self.threads > 1 && waiting >= MIN_SHARED_NODES;
        let size = if is_shared { size * self.threads } else { size };
        let round: Vec<NodeToExpand> = (first..)
            .take(size.min(waiting))
            .map(|node| NodeToExpand {
                state: self.found.state(node).into_owned(),
                inputs: self.found.inputs(node).to_vec(),
            })
            .collect();
        let known = KnownStates::of(&self.found);
        let parts = if is_shared {
            while self.others.len() + 1 < self.threads {
                self.others.push(self.expander.another());
            }
            let examined = ExaminedLimits::new(limits, Some(proceed));
            expand_shared(
                (&mut self.expander, &mut self.others),
                &round,
                known,
                (limits, examined),
            )
        } else {
            let mut part = Expansions::default();
            let mut examined = ExaminedLimits::new(limits, Some(proceed));
            for node in &round {
                self.expander.expand(node, known, &mut part, &mut examined);
            }
            vec![part]
        };
        let executions = parts.iter().flat_map(|part| &part.nodes);
        let executions = executions.map(|node| node.executions).sum();
        self.last_round = (round.len() as u64, executions);
        parts
    }

    /// Returns the coverage counts of each machine.
    fn counts(&self) -> Vec<Vec<u64>> {
        let others = self.others.iter().map(|it| it.system.counts());
        sum(self.expander.system.counts(), others)
    }

    /// Returns the coverage counts after the steps of these nodes of a round; `before` are those before the round.
    fn counts_up_to(&self, nodes: std::ops::Range<u32>, before: Vec<Vec<u64>>) -> Vec<Vec<u64>> {
        let mut again = self.expander.another();
        let at_start = again.system.counts();
        let (mut found, known) = (Expansions::default(), KnownStates::of(&self.found));
        let unlimited = RoundLimits::new(Limits::default(), self.progress(0));
        let mut examined = ExaminedLimits::new(&unlimited, None);
        for node in nodes {
            let node = NodeToExpand {
                state: self.found.state(node).into_owned(),
                inputs: self.found.inputs(node).to_vec(),
            };
            again.expand(&node, known, &mut found, &mut examined);
        }
        let mut counts = again.system.counts();
        for (count, start) in counts.iter_mut().flatten().zip(at_start.iter().flatten()) {
            *count = count.saturating_sub(*start);
        }
        sum(before, std::iter::once(counts))
    }

    /// Adds what was found about the successors of a node.
    fn take_over(
        &mut self,
        node: u32,
        successors: NodeSuccessors,
        part: &mut Expansions,
        numbers: &mut [Option<u32>],
    ) -> Result<(), ExplorationError> {
        self.found.transitions += successors.updating;
        self.lacks_elements |= successors.lacks_elements;
        for outcome in successors.outcomes {
            match outcome {
                StepOutcome::Reached(reached, moved) => {
                    let state = match reached {
                        ReachedState::Known(state) => state,
                        ReachedState::Fresh(index) => {
                            match self.enter(index, Some(node), part, numbers)? {
                                Some(state) => state,
                                None => continue,
                            }
                        }
                    };
                    if self.found.keeps_edges {
                        let label = self.label(moved);
                        let nodes = self.found.nodes_of(state);
                        self.edges.extend(nodes.map(|node| (node, label)));
                    }
                }
                StepOutcome::Failed(decisions, fault) => {
                    self.found.fault(node, decisions, fault)?;
                }
                StepOutcome::Stopped(error) => return Err(error),
            }
        }
        self.finish(node, successors.rests);
        Ok(())
    }

    /// Adds a fresh state with its nodes, unless it is known by now; returns its number, `None` if no number is left.
    fn enter(
        &mut self,
        index: u32,
        parent: Option<u32>,
        part: &mut Expansions,
        numbers: &mut [Option<u32>],
    ) -> Result<Option<u32>, ExplorationError> {
        let Some(number) = numbers.get_mut(index as usize) else {
            return Ok(None);
        };
        if number.is_some() {
            return Ok(*number);
        }
        let Some((state, is_new)) = self.found.states.add(&part.fresh.get(index)) else {
            self.found.incomplete = Some(Incomplete::States);
            return Ok(None);
        };
        *number = Some(state);
        if !is_new {
            return Ok(Some(state));
        }
        self.found.first_nodes.push(self.found.nodes());
        let observation = part.observations.get_mut(index as usize);
        let observation = observation.map(std::mem::take).unwrap_or_default();
        for (condition, fault) in observation.failed {
            self.found.failed_terms.entry(condition).or_insert(fault);
        }
        if let Some(error) = observation.stopped {
            return Err(error);
        }
        for case in observation.cases {
            if !case.is_considered {
                self.found.excluded += 1;
                continue;
            }
            let inputs = self.inputs_number(case.inputs);
            let found = &mut self.found;
            let all = found.truths.iter_mut().zip(&mut found.undefined);
            for ((truths, undefined), truth) in all.zip(&case.truths) {
                truths.push(*truth == Some(true));
                *undefined += u64::from(truth.is_none());
            }
            found.state_of.push(state);
            found.inputs_of.push(inputs);
            found.parents.push(parent);
        }
        Ok(Some(state))
    }

    /// Returns the label of steps that move this.
    fn label(&mut self, moved: MovedSet) -> u32 {
        if !self.expander.has_labels {
            return 0;
        }
        let found = &mut self.found;
        *self.known_labels.entry(moved).or_insert_with(|| {
            found.moved_sets.push(moved);
            found.moved_sets.len() as u32 - 1
        })
    }

    fn inputs_number(&mut self, inputs: Vec<InputValue>) -> u32 {
        if let Some(number) = self.known_inputs.get(&inputs) {
            return *number;
        }
        let number = self.found.add_inputs(inputs.clone());
        self.known_inputs.insert(inputs, number);
        number
    }

    /// Ends the edges of a node, and notes whether its state is stuck.
    fn finish(&mut self, node: u32, rests: bool) {
        let found = &mut self.found;
        if found.keeps_edges {
            self.edges.sort_unstable();
            self.edges.dedup();
            let targets = self.edges.iter().map(|(target, _)| *target);
            found.targets.extend(targets);
            if self.expander.has_labels {
                let labels = self.edges.iter().map(|(_, label)| *label);
                found.labels.extend(labels);
            }
            self.edges.clear();
            found.edge_ends.push(found.targets.len() as u64);
        }
        if self.expander.has_surroundings {
            found.moving.push(!rests);
            return;
        }
        let state = found.state_of.get(node as usize);
        found.rests(node, state.unwrap_or_default(), rests);
    }
}

/// Adds counts of the same machines.
fn sum(mut all: Vec<Vec<u64>>, others: impl Iterator<Item = Vec<Vec<u64>>>) -> Vec<Vec<u64>> {
    for other in others {
        for (count, own) in all.iter_mut().flatten().zip(other.iter().flatten()) {
            *count += own;
        }
    }
    all
}

/// Finds the successors of nodes with several threads; returns them in the order of the nodes.
fn expand_shared<S: TransitionSystem>(
    (own, others): (&mut Expander<'_, S>, &mut [Expander<'_, S>]),
    round: &[NodeToExpand],
    known: KnownStates<'_>,
    (limits, mut examined): (&RoundLimits, ExaminedLimits<'_>),
) -> Vec<Expansions> {
    let parts: Vec<&[NodeToExpand]> = round.chunks(PART_NODES).collect();
    let next = AtomicUsize::new(0);
    let work = |expander: &mut Expander<'_, S>, examined: &mut ExaminedLimits<'_>| {
        let mut done = Vec::new();
        loop {
            let index = next.fetch_add(1, Ordering::Relaxed);
            let Some(part) = parts.get(index) else {
                return done;
            };
            let mut found = Expansions::default();
            for node in *part {
                expander.expand(node, known, &mut found, examined);
            }
            done.push((index, found));
        }
    };
    let mut all = std::thread::scope(|scope| {
        let work = &work;
        let running = others.iter_mut().map(|expander| {
            scope.spawn(move || work(expander, &mut ExaminedLimits::new(limits, None)))
        });
        let running: Vec<_> = running.collect();
        let mut all = work(own, &mut examined);
        for thread in running {
            match thread.join() {
                Ok(done) => all.extend(done),
                Err(panic) => std::panic::resume_unwind(panic),
            }
        }
        all
    });
    all.sort_by_key(|(index, _)| *index);
    all.into_iter().map(|(_, found)| found).collect()
}
