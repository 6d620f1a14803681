//! The exploration in breadth-first order.

use super::cases::InputCases;
use super::command::{CompiledCondition, ConditionCode, GroundTruth, StepCode};
use super::independence::Independence;
use super::layout::{WordLayout, Words, word_of};
use super::machine_steps::{NotWords, WordMachine};
use super::shared_steps::find_shared;
use super::steps::{GroundedSteps, KnownNodes, ReachedWords, StateSteps};
use super::store::{HashedState, WordStore};
use super::stored_words::StoredWords;
use super::symmetry::WordSymmetry;
use super::{Grounded, GroundedStep};
use crate::explore::{
    Conditions, Exploration, ExplorationError, ExplorationOptions, Incomplete, Progress, Reached,
};
use crate::fair_moves::{FairMoves, MovedSet};
use crate::inputs::InputRanges;
use asmotion_ground::{FAULT, accesses_of_term};
use asmotion_lang::{Machine, Value};
use rustc_hash::FxHashMap;

/// The subject and the limits of an exploration.
pub(crate) struct RunRequest<'a> {
    pub grounded: &'a Grounded,
    pub layout: &'a WordLayout,
    pub conditions: &'a Conditions,
    pub options: &'a ExplorationOptions,
    /// Permutations of elements, if there are any.
    pub symmetry: Option<&'a WordSymmetry>,
    pub fair: &'a FairMoves,
}

/// The reason for which an exploration has no result.
#[derive(Debug)]
pub(crate) enum StoppedRun {
    Error(ExplorationError),
    /// A step changes more than the variables.
    NotGrounded,
    /// The layout has no code for a number of this variable.
    Wider(u32, i64),
}

impl From<NotWords> for StoppedRun {
    fn from(reason: NotWords) -> Self {
        match reason {
            NotWords::Alternatives => Self::Error(ExplorationError::Alternatives),
            NotWords::Elsewhere => Self::NotGrounded,
            NotWords::Wider(variable, number) => Self::Wider(variable, number),
        }
    }
}

/// Number of states in a round for each thread. A round is small, so that its results take little memory.
const ROUND_STATES: u32 = 2048;

/// Number of states from which a round is worth more than one thread.
const MIN_SHARED_STATES: u32 = 1024;

/// An exploration in progress. As in [`explorer`](crate::explorer), the threads find the successors of a round of states while nothing
/// that is known changes, and one thread takes them over in order.
pub(crate) struct GroundedRun<'a, const W: usize> {
    request: &'a RunRequest<'a>,
    conditions: &'a [CompiledCondition<W>],
    steps: GroundedSteps<'a, W>,
    /// Which commands influence each other, if steps can be left out.
    independence: Option<Independence>,
    /// Those of the other threads.
    others: Vec<GroundedSteps<'a, W>>,
    store: WordStore<W>,
    found: Exploration,
    /// `None` if each state is one node.
    cases: Option<InputCases>,
    numbers: Vec<i64>,
    edges: Vec<(u32, u32)>,
    /// Indices of the sets in `moved_sets`.
    known_labels: FxHashMap<MovedSet, u32>,
    /// The set that was looked up last.
    last_label: Option<(MovedSet, u32)>,
    /// The node to explore next, and the first one of the next level.
    node: u32,
    level_end: u32,
    /// Number of nodes when the limits were examined.
    examined: u32,
}

/// Number of new nodes after which the limits are examined: a state can have many combinations of inputs.
const EXAMINED_NODES: u32 = 1 << 16;

impl<const W: usize> GroundedRun<'_, W> {
    /// Explores all states.
    pub fn explore(
        machine: &Machine,
        ranges: &InputRanges,
        request: &RunRequest<'_>,
        proceed: &mut dyn FnMut(Progress) -> bool,
    ) -> Result<Exploration, StoppedRun> {
        let Grounded {
            program,
            step,
            conditions,
            has_cases,
            ..
        } = request.grounded;
        let alternatives = match step {
            GroundedStep::Alternatives(alternatives) => alternatives.as_slice(),
            GroundedStep::Rule => &[],
        };
        let code = StepCode::of(program, request.layout, alternatives, request.fair);
        if !request.fair.is_empty() && !code.interpreted.is_empty() {
            return Err(StoppedRun::NotGrounded);
        }
        let independence = independence_of(request, &code);
        let count = conditions.len();
        let conditions = conditions.iter().filter(|_| !has_cases);
        let conditions = conditions.map(|term| CompiledCondition::of(request.layout, term));
        let conditions: Vec<CompiledCondition<W>> = conditions.collect();
        let run = GroundedRun {
            request,
            conditions: &conditions,
            steps: GroundedSteps::new(WordMachine::new(machine, ranges), request, &code),
            independence,
            others: Vec::new(),
            store: WordStore::new(&request.options.storage),
            found: Exploration::new(request.options, count),
            cases: has_cases.then(InputCases::default),
            numbers: Vec::new(),
            edges: Vec::new(),
            known_labels: FxHashMap::default(),
            last_label: None,
            node: 0,
            level_end: 1,
            examined: 0,
        };
        run.run(machine, proceed)
    }

    fn run(
        mut self,
        machine: &Machine,
        proceed: &mut dyn FnMut(Progress) -> bool,
    ) -> Result<Exploration, StoppedRun> {
        let program = &self.request.grounded.program;
        let initial = program.variables.iter().map(|variable| variable.initial);
        let initial: Vec<i64> = initial.collect();
        let encoded = self.request.layout.encode(&initial);
        let initial = encoded.map_err(|variable| {
            let number = initial.get(variable as usize).copied();
            StoppedRun::Wider(variable, number.unwrap_or(FAULT))
        })?;
        self.found.transitions = 1;
        self.arrive(HashedState::of(initial), None, proceed)?;
        self.found.initial = self.node_count();
        self.level_end = self.found.initial;
        self.found.levels.push(0);
        // what is left out in a state depends on those before it
        let threads = match self.independence {
            None => self.request.options.threads as u32,
            Some(_) => 1,
        };
        while self.node < self.node_count() && self.found.incomplete.is_none() {
            let waiting = self.node_count() - self.node;
            if threads > 1 && waiting >= MIN_SHARED_STATES {
                let count = waiting.min(ROUND_STATES.saturating_mul(threads));
                self.round(count, proceed)?;
            } else if self.may_proceed(proceed) {
                self.expand(proceed)?;
                self.node += 1;
            }
            if self.node.is_multiple_of(256) || self.node >= self.node_count() {
                self.found.check_storage().map_err(StoppedRun::Error)?;
            }
            let next = if self.node < self.node_count() {
                self.nodes().state_of(self.node)
            } else {
                self.store.len() as u32
            };
            self.store.forget_before(next);
        }
        self.found.explored = self.node;
        if self.found.counts.is_empty() {
            let others = self.others.iter().map(GroundedSteps::counts);
            self.found.counts = vec![sum(self.steps.counts(), others)];
        }
        self.found.words = Some(Box::new(StoredWords {
            store: self.store,
            program: program.clone(),
            layout: self.request.layout.clone(),
            machine: machine.clone(),
            symmetry: self.request.symmetry.cloned(),
        }));
        Ok(self.found)
    }

    fn nodes(&self) -> KnownNodes<'_, W> {
        KnownNodes::of(&self.store, self.cases.as_ref(), &self.found)
    }

    fn node_count(&self) -> u32 {
        match &self.cases {
            None => self.store.len() as u32,
            Some(_) => self.found.state_of.len() as u32,
        }
    }

    /// Begins a level if the next node is the first one of it, and examines the limits.
    fn may_proceed(&mut self, proceed: &mut dyn FnMut(Progress) -> bool) -> bool {
        let node = self.node;
        if node == self.level_end {
            self.found.levels.push(node);
            self.level_end = self.node_count();
        }
        let limits = self.request.options.limits;
        let limit = self.found.incomplete;
        let reached = self.reached();
        self.found.incomplete = limit.or_else(|| self.found.limit(limits, reached, proceed));
        self.found.incomplete.is_none()
    }

    fn reached(&self) -> Reached {
        Reached {
            node: self.node,
            states: self.store.len() as u64,
            explored: self.nodes().state_of(self.node),
            memory: self.store.memory() as u64,
        }
    }

    /// Returns the state of the next node.
    fn state(&self) -> Result<Words<W>, StoppedRun> {
        let state = self.store.get(self.nodes().state_of(self.node));
        if state.is_none() {
            // it cannot be read
            self.found.check_storage().map_err(StoppedRun::Error)?;
        }
        state.ok_or(StoppedRun::NotGrounded)
    }

    /// Finds the successors of the next node.
    fn expand(&mut self, proceed: &mut dyn FnMut(Progress) -> bool) -> Result<(), StoppedRun> {
        let state = self.state()?;
        let nodes = KnownNodes::of(&self.store, self.cases.as_ref(), &self.found);
        nodes.give(self.node, &mut self.steps);
        let failed = self.steps.find(&state)?;
        if failed.is_empty() {
            self.leave_out(&state);
        }
        // the places of all successors are read first, so that the reads overlap
        let mut touched = 0;
        for next in &self.steps.successors.states {
            touched |= self.store.touch(next.hash);
        }
        std::hint::black_box(touched);
        for index in 0..self.steps.successors.states.len() {
            let Some(next) = self.steps.successors.states.get(index).copied() else {
                continue;
            };
            if let Some(number) = self.arrive(next, Some((self.node, &state)), proceed)?
                && self.found.keeps_edges
            {
                let moved = self.steps.successors.moved.get(index).copied();
                self.edge(number, moved.unwrap_or_default());
            }
        }
        let successors = &self.steps.successors;
        self.finish(StateSteps {
            end: 0,
            updating: successors.updating,
            is_idle: successors.is_idle,
            rests: successors.rests,
            failed,
            stopped: None,
        })
    }

    /// Leaves out successors of the next node that are reached in another order of steps.
    fn leave_out(&mut self, state: &Words<W>) {
        let successors = &self.steps.successors;
        let Some(independence) = &self.independence else {
            return;
        };
        if successors.states.len() < 2 || successors.commands.len() != successors.states.len() {
            return;
        }
        let changes = |at: &usize| {
            let next = successors.states.get(*at);
            next.is_some_and(|next| next.state != *state)
        };
        let positions: Vec<usize> = (0..successors.states.len()).filter(changes).collect();
        let commands = positions.iter();
        let commands = commands.filter_map(|at| successors.commands.get(*at).copied());
        let is_new = |index: usize| {
            let at = positions.get(index);
            let next = at.and_then(|at| successors.states.get(*at));
            next.is_some_and(|next| self.store.find(next).is_ok_and(|it| it > self.node))
                || next.is_some_and(|next| self.store.find(next).is_err())
        };
        let Some(kept) = independence.stubborn(state, &commands.collect::<Vec<_>>(), is_new) else {
            return;
        };
        let mut all = vec![true; successors.states.len()];
        for (at, is_kept) in positions.iter().zip(kept) {
            if let Some(place) = all.get_mut(*at) {
                *place = is_kept;
            }
        }
        self.steps.retain(&all);
        self.found.has_left_out_steps = true;
    }

    /// Finds the successors of the next nodes with all threads, and takes them over.
    fn round(
        &mut self,
        count: u32,
        proceed: &mut dyn FnMut(Progress) -> bool,
    ) -> Result<(), StoppedRun> {
        while self.others.len() + 1 < self.request.options.threads {
            self.others.push(self.steps.another());
        }
        let others = self.others.iter().map(GroundedSteps::counts);
        let before = sum(self.steps.counts(), others);
        let first = self.node;
        let parts = find_shared(
            &mut self.steps,
            &mut self.others,
            first..first + count,
            KnownNodes::of(&self.store, self.cases.as_ref(), &self.found),
        );
        for part in parts {
            let mut start = 0;
            for found in part.states {
                if !self.may_proceed(proceed) {
                    // what later states execute does not count
                    self.found.counts = vec![self.counts_up_to(first, before)];
                    return Ok(());
                }
                if let Some(stopped) = found.stopped {
                    return Err(stopped);
                }
                let state = self.state()?;
                for index in start..found.end {
                    let number = match part.reached.get(index) {
                        Some(ReachedWords::Known(number)) => Some(*number),
                        Some(ReachedWords::Fresh(next)) => {
                            self.arrive(*next, Some((self.node, &state)), proceed)?
                        }
                        None => None,
                    };
                    if let Some(number) = number
                        && self.found.keeps_edges
                    {
                        let moved = part.moved.get(index).copied();
                        self.edge(number, moved.unwrap_or_default());
                    }
                }
                start = found.end;
                self.finish(found)?;
                self.node += 1;
            }
        }
        Ok(())
    }

    /// Returns the coverage counts after the steps of the nodes from this one up to the next one; `before` are those before.
    fn counts_up_to(&self, first: u32, before: Vec<u64>) -> Vec<u64> {
        let mut again = self.steps.another();
        let at_start = again.counts();
        for node in first..self.node {
            let nodes = self.nodes();
            if let Some(state) = self.store.get(nodes.state_of(node)) {
                nodes.give(node, &mut again);
                // cannot stop, as it did not before
                let _ = again.find(&state);
            }
        }
        let counts = again.counts().into_iter().zip(at_start);
        let counts = counts.map(|(count, start)| count.saturating_sub(start));
        sum(before, std::iter::once(counts.collect()))
    }

    /// Adds the edges to the nodes of a state.
    fn edge(&mut self, target: u32, moved: MovedSet) {
        let label = self.label(moved);
        match &self.cases {
            None => self.edges.push((target, label)),
            Some(_) => {
                let nodes = self.found.nodes_of(target);
                self.edges.extend(nodes.map(|node| (node, label)));
            }
        }
    }

    /// Ends the edges of the next node, and notes what else was found about it.
    fn finish(&mut self, found: StateSteps) -> Result<(), StoppedRun> {
        let node = self.node;
        let state = self.nodes().state_of(node);
        self.found.transitions += found.updating;
        for (decisions, fault) in found.failed {
            let recorded = self.found.fault(node, decisions, fault);
            recorded.map_err(StoppedRun::Error)?;
        }
        if self.found.keeps_edges {
            if found.is_idle {
                self.edge(state, 0);
            }
            self.edges.sort_unstable();
            self.edges.dedup();
            let targets = self.edges.iter().map(|(target, _)| *target);
            self.found.targets.extend(targets);
            if self.steps.has_labels {
                let labels = self.edges.iter().map(|(_, label)| *label);
                self.found.labels.extend(labels);
            }
            self.edges.clear();
            self.found.edge_ends.push(self.found.targets.len() as u64);
        }
        match &self.cases {
            None if found.rests => self.found.stuck.push(node),
            None => {}
            Some(_) => self.found.rests(node, state, found.rests),
        }
        Ok(())
    }

    /// Returns the label of steps that move this.
    fn label(&mut self, moved: MovedSet) -> u32 {
        if !self.steps.has_labels {
            return 0;
        }
        if let Some((last, label)) = self.last_label
            && last == moved
        {
            return label;
        }
        let sets = &mut self.found.moved_sets;
        let label = *self.known_labels.entry(moved).or_insert_with(|| {
            sets.push(moved);
            sets.len() as u32 - 1
        });
        self.last_label = Some((moved, label));
        label
    }

    /// Adds a state and evaluates the conditions in it if it is new. Returns its number, `None` if no number is left.
    #[inline]
    fn arrive(
        &mut self,
        new: HashedState<W>,
        parent: Option<(u32, &Words<W>)>,
        proceed: &mut dyn FnMut(Progress) -> bool,
    ) -> Result<Option<u32>, StoppedRun> {
        if self.found.incomplete.is_some() {
            return Ok(None);
        }
        let Some((number, is_new)) = self.store.add(&new) else {
            self.found.incomplete = Some(Incomplete::States);
            return Ok(None);
        };
        if is_new && let Some(cases) = &mut self.cases {
            let Grounded {
                program,
                conditions,
                ..
            } = self.request.grounded;
            cases.observe(
                (program, self.request.layout),
                (conditions, self.request.conditions),
                (number, &new.state),
                parent.map(|(node, _)| node),
                &mut self.found,
            )?;
            let count = self.node_count();
            if count - self.examined >= EXAMINED_NODES {
                self.examined = count;
                let (limits, reached) = (self.request.options.limits, self.reached());
                self.found.incomplete = self.found.resource_limit(limits, reached, proceed);
            }
        } else if is_new {
            self.found.parents.push(parent.map(|(node, _)| node));
            for index in 0..self.conditions.len() {
                self.observe(index, &new.state, parent)?;
            }
        }
        Ok(Some(number))
    }

    /// Evaluates a condition in a new state.
    fn observe(
        &mut self,
        index: usize,
        state: &Words<W>,
        parent: Option<(u32, &Words<W>)>,
    ) -> Result<(), StoppedRun> {
        let Some(condition) = self.conditions.get(index) else {
            return Ok(());
        };
        let layout = self.request.layout;
        let known = parent.and_then(|(parent, before)| {
            let words = state.iter().enumerate();
            let changed = words.fold(0, |all, (index, now)| {
                all | (now ^ word_of(before, index)) & word_of(&condition.reads, index)
            });
            let truth = self.found.truths.get(index)?.get(parent);
            // a part of a term may also have been undef, which counts as false
            let is_known = truth || !matches!(condition.code, ConditionCode::Term(_));
            (changed == 0 && is_known).then_some(truth)
        });
        let truth = match known {
            Some(truth) => truth,
            None => match condition.truth(layout, state, &mut self.numbers) {
                GroundTruth::True => true,
                GroundTruth::False => false,
                GroundTruth::Undef => {
                    self.count_undefined(index);
                    false
                }
                GroundTruth::Fault => self.machine_condition(index, state)?,
            },
        };
        if let Some(truths) = self.found.truths.get_mut(index) {
            truths.push(truth);
        }
        Ok(())
    }

    fn count_undefined(&mut self, condition: usize) {
        if let Some(count) = self.found.undefined.get_mut(condition) {
            *count += 1;
        }
    }

    #[cold]
    fn machine_condition(&mut self, index: usize, state: &Words<W>) -> Result<bool, StoppedRun> {
        let program = &self.request.grounded.program;
        let Some(term) = self.request.conditions.terms.get(index) else {
            return Ok(false);
        };
        let value = self
            .steps
            .machine
            .condition(program, self.request.layout, state, term.term);
        match value.ok_or(StoppedRun::NotGrounded)? {
            Ok(value) => {
                if value.is_undef() {
                    self.count_undefined(index);
                }
                Ok(value == Value::Bool(true))
            }
            Err(fault) if fault.is_of_input() => {
                Err(StoppedRun::Error(ExplorationError::Input(fault)))
            }
            Err(fault) => {
                self.found.failed_terms.entry(index).or_insert(fault);
                self.count_undefined(index);
                Ok(false)
            }
        }
    }
}

/// Returns which commands influence each other, if steps may be left out.
fn independence_of<const W: usize>(
    request: &RunRequest<'_>,
    code: &StepCode<W>,
) -> Option<Independence> {
    let Grounded {
        step,
        conditions,
        has_cases,
        ..
    } = request.grounded;
    let is_simple = matches!(step, GroundedStep::Alternatives(_)) && code.interpreted.is_empty();
    if !request.options.independent
        || request.options.keeps_edges
        // within a number of steps, another order can be too long
        || request.options.limits.depth.is_some()
        || request.symmetry.is_some()
        || !request.fair.is_empty()
        || *has_cases
        || !is_simple
    {
        return None;
    }
    let visible = conditions.iter().flat_map(|it| accesses_of_term(it).reads);
    Independence::of(request.layout, &code.accesses, &visible.collect())
}

/// Adds counts.
fn sum(mut all: Vec<u64>, others: impl Iterator<Item = Vec<u64>>) -> Vec<u64> {
    for other in others {
        for (count, own) in all.iter_mut().zip(other) {
            *count += own;
        }
    }
    all
}
