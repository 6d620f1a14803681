//! The exploration in breadth-first order.

use super::command::{CompiledCondition, ConditionCode, GroundTruth, NoSuccessor, StepCode};
use super::layout::{WordLayout, Words};
use super::machine_steps::{NotWords, WordMachine};
use super::store::{HashedState, WordStore};
use super::{Grounded, GroundedStep};
use crate::decisions::{Decisions, MAX_EXECUTIONS};
use crate::explore::{
    Conditions, Exploration, ExplorationError, Incomplete, Limits, NO_PARENT, Progress, Reached,
    Truths, WordStates,
};
use crate::fair_moves::{FairMoves, MovedSet};
use crate::inputs::InputRanges;
use asmotion_ground::{
    FAULT, GroundAlternative, GroundProgram, GroundRule, GroundUpdates, Valuation, evaluate,
    execute,
};
use asmotion_lang::{Machine, Value};
use std::collections::HashMap;
use std::fmt;

/// What to explore, and how far.
pub(crate) struct RunRequest<'a> {
    pub grounded: &'a Grounded,
    pub layout: &'a WordLayout,
    pub conditions: &'a Conditions,
    pub limits: Limits,
    pub keeps_edges: bool,
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

/// The successors of a state.
struct Successors<const W: usize> {
    states: Vec<HashedState<W>>,
    /// What the step to each state moves, if fairness refers to it.
    moved: Vec<MovedSet>,
    /// Number of executions that update a location.
    updating: u64,
    /// `true` if an execution updates nothing, as far as this is examined.
    is_idle: bool,
}

/// The inputs and choices of an execution, as far as they are decided.
struct DecidedNumbers<'a> {
    program: &'a GroundProgram,
    decisions: &'a Decisions,
    /// Numbers of the inputs that the execution has read.
    read: &'a mut Vec<(u32, i64)>,
}

impl Valuation for DecidedNumbers<'_> {
    fn input(&mut self, input: u32) -> i64 {
        if let Some((_, number)) = self.read.iter().find(|(known, _)| *known == input) {
            return *number;
        }
        let Some(declared) = self.program.inputs.get(input as usize) else {
            return FAULT;
        };
        let taken = self.decisions.decide(declared.values.len());
        let number = declared.values.get(taken).copied().unwrap_or(FAULT);
        self.read.push((input, number));
        number
    }

    fn choose(&mut self, count: usize) -> usize {
        self.decisions.decide(count)
    }
}

/// An exploration in progress.
pub(crate) struct GroundedRun<'a, const W: usize> {
    request: &'a RunRequest<'a>,
    code: StepCode<W>,
    conditions: Vec<CompiledCondition<W>>,
    machine: WordMachine<'a>,
    store: WordStore<W>,
    found: Exploration,
    /// `true` for each command that was executed.
    executed: Vec<bool>,
    /// Commands without updates that may still execute counters that nothing has executed.
    pending: Vec<usize>,
    successors: Successors<W>,
    updates: GroundUpdates,
    numbers: Vec<i64>,
    edges: Vec<(u32, u32)>,
    /// `true` if fairness refers to the labels of transitions.
    has_labels: bool,
    /// Indices of the sets in `moved_sets`.
    known_labels: HashMap<MovedSet, u32>,
    decisions: Decisions,
    read: Vec<(u32, i64)>,
}

impl<'a, const W: usize> GroundedRun<'a, W> {
    /// Explores all states.
    pub fn explore(
        machine: &Machine,
        ranges: &'a InputRanges,
        request: &'a RunRequest<'a>,
        proceed: &mut dyn FnMut(Progress) -> bool,
    ) -> Result<Exploration, StoppedRun> {
        let Grounded {
            program,
            step,
            conditions,
        } = request.grounded;
        let alternatives = match step {
            GroundedStep::Alternatives(alternatives) => alternatives.as_slice(),
            GroundedStep::Rule => &[],
        };
        let code = StepCode::of(program, request.layout, alternatives, request.fair);
        if !request.fair.is_empty() && !code.interpreted.is_empty() {
            return Err(StoppedRun::NotGrounded);
        }
        let conditions = conditions.iter();
        let conditions = conditions.map(|term| CompiledCondition::of(request.layout, term));
        let conditions: Vec<CompiledCondition<W>> = conditions.collect();
        let count = conditions.len();
        let run = Self {
            request,
            executed: vec![false; code.commands.len()],
            pending: (0..code.idle.len()).collect(),
            code,
            conditions,
            machine: WordMachine::new(machine, ranges),
            store: WordStore::new(),
            found: Exploration {
                truths: vec![Truths::default(); count],
                undefined: vec![0; count],
                keeps_edges: request.keeps_edges,
                ..Exploration::default()
            },
            successors: Successors {
                states: Vec::new(),
                moved: Vec::new(),
                updating: 0,
                is_idle: false,
            },
            updates: GroundUpdates {
                list: Vec::new(),
                counts: vec![0; program.counters],
            },
            numbers: Vec::new(),
            edges: Vec::new(),
            has_labels: request.keeps_edges && !request.fair.is_empty(),
            known_labels: HashMap::new(),
            decisions: Decisions::default(),
            read: Vec::new(),
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
        self.arrive(HashedState::of(initial), None)?;
        self.found.initial = 1;
        self.found.levels.push(0);
        let mut node = 0u32;
        let mut level_end = 1u32;
        while (node as usize) < self.store.len() {
            if node == level_end {
                self.found.levels.push(node);
                level_end = self.store.len() as u32;
            }
            let reached = Reached {
                node,
                states: self.store.len() as u64,
                explored: node,
                memory: self.store.memory() as u64,
            };
            let limit = self.found.incomplete;
            let limit = limit.or_else(|| self.found.limit(self.request.limits, reached, proceed));
            if let Some(reason) = limit {
                self.found.incomplete = Some(reason);
                break;
            }
            self.expand(node)?;
            node += 1;
        }
        self.found.explored = node;
        self.found.counts = vec![self.counts()];
        self.found.words = Some(Box::new(StoredWords {
            store: self.store,
            program: program.clone(),
            layout: self.request.layout.clone(),
            machine: machine.clone(),
        }));
        Ok(self.found)
    }

    /// Finds the successors of a node.
    fn expand(&mut self, node: u32) -> Result<(), StoppedRun> {
        let Some(state) = self.store.get(node).copied() else {
            return Ok(());
        };
        self.successors.states.clear();
        self.successors.moved.clear();
        self.successors.updating = 0;
        self.successors.is_idle = false;
        let has_failed = match self.grounded_steps(&state) {
            Ok(()) => false,
            Err(NoSuccessor::Wider(variable, number)) => {
                return Err(StoppedRun::Wider(variable, number));
            }
            // the label of a machine's step is not known
            Err(NoSuccessor::Machine) if self.has_labels => return Err(StoppedRun::NotGrounded),
            Err(NoSuccessor::Machine) => self.machine_steps(node, &state)?,
        };
        self.found.transitions += self.successors.updating;
        // the places of all successors are read first, so that the reads overlap
        let mut touched = 0;
        for next in &self.successors.states {
            touched |= self.store.touch(next.hash);
        }
        std::hint::black_box(touched);
        let mut rests = !has_failed;
        self.edges.clear();
        for index in 0..self.successors.states.len() {
            let Some(next) = self.successors.states.get(index).copied() else {
                continue;
            };
            rests &= next.state == state;
            if let Some(number) = self.arrive(next, Some((node, &state)))?
                && self.found.keeps_edges
            {
                let moved = self.successors.moved.get(index).copied().unwrap_or(0);
                let label = self.label(moved);
                self.edges.push((number, label));
            }
        }
        if self.found.keeps_edges {
            if self.successors.is_idle {
                let label = self.label(0);
                self.edges.push((node, label));
            }
            self.edges.sort_unstable();
            self.edges.dedup();
            let targets = self.edges.iter().map(|(target, _)| target);
            self.found.targets.extend(targets);
            if self.has_labels {
                let labels = self.edges.iter().map(|(_, label)| label);
                self.found.labels.extend(labels);
            }
            self.found.edge_ends.push(self.found.targets.len() as u64);
        }
        if rests {
            self.found.stuck.push(node);
        }
        Ok(())
    }

    /// Returns the label of steps that move this.
    fn label(&mut self, moved: MovedSet) -> u32 {
        if !self.has_labels {
            return 0;
        }
        let sets = &mut self.found.moved_sets;
        *self.known_labels.entry(moved).or_insert_with(|| {
            sets.push(moved);
            sets.len() as u32 - 1
        })
    }

    /// Adds a state and evaluates the conditions in it if it is new. Returns its number, `None` if no number is left.
    #[inline]
    fn arrive(
        &mut self,
        new: HashedState<W>,
        parent: Option<(u32, &Words<W>)>,
    ) -> Result<Option<u32>, StoppedRun> {
        let Some((number, is_new)) = self.store.add(&new) else {
            self.found.incomplete = Some(Incomplete::States);
            return Ok(None);
        };
        if is_new {
            self.found
                .parents
                .push(parent.map_or(NO_PARENT, |(node, _)| node));
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
            let words = state.iter().zip(before).zip(&condition.reads);
            let changed = words.fold(0, |all, ((now, before), reads)| {
                all | (now ^ before) & reads
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

    /// Finds the successors of a state by a machine; returns `true` if a step fails.
    #[cold]
    fn machine_steps(&mut self, node: u32, state: &Words<W>) -> Result<bool, StoppedRun> {
        let program = &self.request.grounded.program;
        let steps = self.machine.steps(program, self.request.layout, state)?;
        self.successors.states.clear();
        self.successors.updating = 0;
        for (next, has_updates) in steps.next {
            self.successors.updating += u64::from(has_updates);
            self.successors.states.push(HashedState::of(next));
        }
        let has_failed = !steps.faults.is_empty();
        for (decisions, fault) in steps.faults {
            let recorded = self.found.fault(node, decisions, fault);
            recorded.map_err(StoppedRun::Error)?;
        }
        Ok(has_failed)
    }

    /// Finds the successors of a state.
    #[inline]
    fn grounded_steps(&mut self, state: &Words<W>) -> Result<(), NoSuccessor> {
        if let GroundedStep::Rule = self.request.grounded.step {
            return self.executions(state);
        }
        let layout = self.request.layout;
        let mut interpreted = 0;
        for (index, command) in self.code.commands.iter().enumerate() {
            while let Some((_, alternative)) = self
                .code
                .interpreted
                .get(interpreted)
                .filter(|(at, _)| *at <= index)
            {
                interpreted += 1;
                let grounded = self.request.grounded;
                let successors = &mut self.successors;
                let (numbers, updates) = (&mut self.numbers, &mut self.updates);
                alternative_step(
                    grounded,
                    layout,
                    alternative,
                    state,
                    numbers,
                    updates,
                    successors,
                )?;
            }
            if !command.when.holds(state) {
                continue;
            }
            let next = command.next(layout, state)?;
            self.successors.states.push(HashedState::of(next));
            self.successors.updating += 1;
            if self.has_labels {
                let moved = if next == *state { 0 } else { command.moved };
                self.successors.moved.push(moved);
            }
            if let Some(executed) = self.executed.get_mut(index) {
                *executed = true;
            }
        }
        while let Some((_, alternative)) = self.code.interpreted.get(interpreted) {
            interpreted += 1;
            let grounded = self.request.grounded;
            let successors = &mut self.successors;
            let (numbers, updates) = (&mut self.numbers, &mut self.updates);
            alternative_step(
                grounded,
                layout,
                alternative,
                state,
                numbers,
                updates,
                successors,
            )?;
        }
        if self.found.keeps_edges && !self.successors.is_idle {
            let mut idle = self.code.idle.iter();
            self.successors.is_idle = idle.any(|command| command.when.holds(state));
        }
        if !self.pending.is_empty() {
            self.cover(state);
        }
        Ok(())
    }

    /// Counts the parts that commands without updates execute.
    fn cover(&mut self, state: &Words<W>) {
        let Self {
            pending,
            code,
            updates,
            ..
        } = self;
        pending.retain(|index| {
            let Some(command) = code.idle.get(*index) else {
                return false;
            };
            let count = |counter: &u32| updates.counts.get(*counter as usize).copied();
            if command.counters.iter().all(|it| count(it) != Some(0)) {
                return false;
            }
            let holds = command.when.holds(state);
            if holds {
                for counter in &command.counters {
                    if let Some(count) = updates.counts.get_mut(*counter as usize) {
                        *count += 1;
                    }
                }
            }
            !holds
        });
    }

    /// Executes the rule once for each combination of choices and inputs.
    fn executions(&mut self, state: &Words<W>) -> Result<(), NoSuccessor> {
        let Grounded { program, .. } = self.request.grounded;
        let layout = self.request.layout;
        layout.decode(state, &mut self.numbers);
        self.decisions.restart();
        let mut executions = 0;
        loop {
            executions += 1;
            if executions > MAX_EXECUTIONS {
                // the machine finds as many, and reports it
                return Err(NoSuccessor::Machine);
            }
            self.read.clear();
            let mut valuation = DecidedNumbers {
                program,
                decisions: &self.decisions,
                read: &mut self.read,
            };
            let (numbers, updates) = (&mut self.numbers, &mut self.updates);
            if !execute(program, &program.rule, numbers, &mut valuation, updates) {
                return Err(NoSuccessor::Machine);
            }
            let next = updated(layout, state, updates)?;
            self.successors.updating += u64::from(!updates.list.is_empty());
            self.successors.states.push(HashedState::of(next));
            if !self.decisions.advance() {
                return Ok(());
            }
        }
    }

    /// Returns the coverage counts.
    fn counts(&self) -> Vec<u64> {
        let mut counts = self.updates.counts.clone();
        for (command, executed) in self.code.commands.iter().zip(&self.executed) {
            for counter in command.counters.iter().filter(|_| *executed) {
                if let Some(count) = counts.get_mut(*counter as usize) {
                    *count += 1;
                }
            }
        }
        for (count, own) in counts.iter_mut().zip(self.machine.machine.counts()) {
            *count += own;
        }
        counts
    }
}

/// Executes an alternative part by part.
fn alternative_step<const W: usize>(
    grounded: &Grounded,
    layout: &WordLayout,
    alternative: &GroundAlternative,
    state: &Words<W>,
    numbers: &mut Vec<i64>,
    updates: &mut GroundUpdates,
    successors: &mut Successors<W>,
) -> Result<(), NoSuccessor> {
    layout.decode(state, numbers);
    let mut closed = super::case::Closed;
    for guard in &alternative.guards {
        match evaluate(guard, numbers, &mut closed) {
            1 => {}
            0 => return Ok(()),
            _ => return Err(NoSuccessor::Machine),
        }
    }
    let rule: &GroundRule = &alternative.rule;
    if !execute(&grounded.program, rule, numbers, &mut closed, updates) {
        return Err(NoSuccessor::Machine);
    }
    let next = updated(layout, state, updates)?;
    successors.updating += u64::from(!updates.list.is_empty());
    successors.states.push(HashedState::of(next));
    Ok(())
}

/// Returns the state after the updates.
fn updated<const W: usize>(
    layout: &WordLayout,
    state: &Words<W>,
    updates: &GroundUpdates,
) -> Result<Words<W>, NoSuccessor> {
    let mut next = *state;
    for (variable, number) in &updates.list {
        let field = layout.field(*variable).ok_or(NoSuccessor::Machine)?;
        let code = field.code(*number);
        field.set(
            &mut next,
            code.ok_or(NoSuccessor::Wider(*variable, *number))?,
        );
    }
    Ok(next)
}

/// The states of a finished exploration.
struct StoredWords<const W: usize> {
    store: WordStore<W>,
    program: GroundProgram,
    layout: WordLayout,
    machine: Machine,
}

impl<const W: usize> fmt::Debug for StoredWords<W> {
    fn fmt(&self, to: &mut fmt::Formatter<'_>) -> fmt::Result {
        to.debug_struct("StoredWords")
            .field("states", &self.store.len())
            .finish_non_exhaustive()
    }
}

impl<const W: usize> WordStates for StoredWords<W> {
    fn len(&self) -> usize {
        self.store.len()
    }

    fn bytes(&self, state: u32) -> Vec<u8> {
        let mut machine = self.machine.clone();
        let slots = machine.slots_mut();
        let words = self.store.get(state).copied().unwrap_or([0; W]);
        for (variable, field) in self.program.variables.iter().zip(&self.layout.fields) {
            if let Some(slot) = slots.get_mut(variable.slot as usize) {
                *slot = variable.sort.value(field.number(field.get(&words)));
            }
        }
        let mut bytes = Vec::new();
        machine.pack_state(&mut bytes);
        bytes
    }

    fn memory(&self) -> usize {
        self.store.memory()
    }
}
