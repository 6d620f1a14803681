//! The successors of states, found without changing what is known of the exploration, so that several threads can find those of
//! different states at the same time.

use super::cases::{InputCases, InputNumbers};
use super::command::{NoSuccessor, StepCode};
use super::layout::{WordLayout, Words};
use super::machine_steps::WordMachine;
use super::run::{RunRequest, StoppedRun};
use super::store::{HashedState, WordStore};
use super::{Grounded, GroundedStep};
use crate::decisions::{Decision, Decisions, InputValue, MAX_EXECUTIONS};
use crate::explore::Exploration;
use crate::fair_moves::MovedSet;
use crate::spill::Table;
use crate::transition::MachineFault;
use asmotion_ground::{
    FAULT, GroundAlternative, GroundProgram, GroundRule, GroundUpdates, Valuation, evaluate,
    execute,
};

/// A step that fails: its decisions and the fault.
pub(crate) type FailedStep = (Vec<Decision>, MachineFault);

/// The successors of a state.
#[derive(Debug)]
pub(crate) struct Successors<const W: usize> {
    pub states: Vec<HashedState<W>>,
    /// Agents and rules that the step to each state moves, if fairness refers to them.
    pub moved: Vec<MovedSet>,
    /// Number of executions that update a location.
    pub updating: u64,
    /// `true` if an execution updates nothing, as far as this is examined.
    pub is_idle: bool,
    /// `true` if no step changes the state, and none fails.
    pub rests: bool,
    /// The command that leads to each state; empty if not all of them stem from commands.
    pub commands: Vec<usize>,
}

/// The inputs and choices of an execution, as far as they are decided.
pub(crate) struct DecidedNumbers<'a> {
    pub program: &'a GroundProgram,
    pub decisions: &'a Decisions,
    /// Numbers of the inputs that are known, and of those that the execution has read.
    pub read: &'a mut Vec<(u32, i64)>,
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

/// Finds successors.
pub(crate) struct GroundedSteps<'a, const W: usize> {
    request: &'a RunRequest<'a>,
    code: &'a StepCode<W>,
    pub machine: WordMachine<'a>,
    executed: Vec<bool>,
    /// For each command without updates, `true` until it has held in a state: its counters may be those of parts that nothing else
    /// executes.
    pending: Vec<bool>,
    pub successors: Successors<W>,
    updates: GroundUpdates,
    numbers: Vec<i64>,
    decisions: Decisions,
    read: InputNumbers,
    /// The inputs that are known, as numbers and as values.
    known: InputNumbers,
    known_values: Vec<InputValue>,
    /// `true` if fairness refers to the labels of transitions.
    pub has_labels: bool,
}

impl<'a, const W: usize> GroundedSteps<'a, W> {
    pub fn new(
        machine: WordMachine<'a>,
        request: &'a RunRequest<'a>,
        code: &'a StepCode<W>,
    ) -> Self {
        Self {
            request,
            executed: vec![false; code.commands.len()],
            pending: vec![true; code.idle.len()],
            code,
            machine,
            successors: Successors {
                states: Vec::new(),
                moved: Vec::new(),
                updating: 0,
                is_idle: false,
                rests: false,
                commands: Vec::new(),
            },
            updates: GroundUpdates {
                list: Vec::new(),
                counts: vec![0; request.grounded.program.counters],
            },
            numbers: Vec::new(),
            decisions: Decisions::default(),
            read: Vec::new(),
            known: Vec::new(),
            known_values: Vec::new(),
            has_labels: request.options.keeps_edges && !request.fair.is_empty(),
        }
    }

    /// Returns another one, which has executed nothing.
    pub fn another(&self) -> Self {
        let machine = WordMachine::new(&self.machine.machine, self.machine.ranges);
        Self::new(machine, self.request, self.code)
    }

    /// Gives the inputs that the next steps read; others are decided.
    pub fn give(&mut self, numbers: &InputNumbers, values: &[InputValue]) {
        self.known.clone_from(numbers);
        self.known_values.clear();
        self.known_values.extend_from_slice(values);
    }

    /// Finds the successors of a state; returns the steps that fail.
    pub fn find(&mut self, state: &Words<W>) -> Result<Vec<FailedStep>, StoppedRun> {
        self.successors.states.clear();
        self.successors.moved.clear();
        self.successors.commands.clear();
        self.successors.updating = 0;
        self.successors.is_idle = false;
        let failed = match self.grounded_steps(state) {
            Ok(()) => Vec::new(),
            Err(NoSuccessor::Wider(variable, number)) => {
                return Err(StoppedRun::Wider(variable, number));
            }
            // the label of a machine's step is not known
            Err(NoSuccessor::Machine) if self.has_labels => return Err(StoppedRun::NotGrounded),
            // a machine would execute what was left out, too
            Err(NoSuccessor::Machine) if !self.request.grounded.left_out.is_empty() => {
                return Err(StoppedRun::NotGrounded);
            }
            Err(NoSuccessor::Machine) => self.machine_steps(state)?,
        };
        let successors = &mut self.successors;
        let mut states = successors.states.iter();
        // a step to a permuted state changes the state
        successors.rests = failed.is_empty() && states.all(|next| next.state == *state);
        if let Some(symmetry) = self.request.symmetry {
            for next in &mut successors.states {
                *next = HashedState::of(symmetry.canonical(&next.state));
            }
        }
        Ok(failed)
    }

    /// Leaves out successors.
    pub fn retain(&mut self, kept: &[bool]) {
        let mut is_kept = kept.iter().copied().chain(std::iter::repeat(true));
        self.successors
            .states
            .retain(|_| is_kept.next().unwrap_or(true));
        self.successors.updating = self.successors.states.len() as u64;
    }

    /// Finds the successors of a state by a machine; returns the steps that fail.
    #[cold]
    fn machine_steps(&mut self, state: &Words<W>) -> Result<Vec<FailedStep>, StoppedRun> {
        let program = &self.request.grounded.program;
        let steps = self
            .machine
            .steps(program, self.request.layout, state, &self.known_values)?;
        self.successors.states.clear();
        self.successors.commands.clear();
        self.successors.updating = 0;
        for (next, has_updates) in steps.next {
            self.successors.updating += u64::from(has_updates);
            self.successors.states.push(HashedState::of(next));
        }
        Ok(steps.faults)
    }

    /// Finds the successors of a state.
    #[inline]
    fn grounded_steps(&mut self, state: &Words<W>) -> Result<(), NoSuccessor> {
        if let GroundedStep::Rule = self.request.grounded.step {
            return self.executions(state);
        }
        let layout = self.request.layout;
        let mut interpreted = 0;
        for index in self.code.index.held(state) {
            interpreted = self.interpreted_steps(state, interpreted, index)?;
            let Some(command) = self.code.commands.get(index) else {
                continue;
            };
            let next = command.next(layout, state)?;
            self.successors.states.push(HashedState::of(next));
            self.successors.updating += 1;
            if self.request.options.independent {
                self.successors.commands.push(index);
            }
            if self.has_labels {
                let moved = if next == *state { 0 } else { command.moved };
                self.successors.moved.push(moved);
            }
            if let Some(executed) = self.executed.get_mut(index) {
                *executed = true;
            }
        }
        self.interpreted_steps(state, interpreted, usize::MAX)?;
        if self.request.options.keeps_edges && !self.successors.is_idle {
            self.successors.is_idle = self.code.idle_index.held(state).next().is_some();
        }
        self.cover(state);
        Ok(())
    }

    /// Executes the alternatives from one on that come before a command. Returns the number of the next one.
    fn interpreted_steps(
        &mut self,
        state: &Words<W>,
        from: usize,
        command: usize,
    ) -> Result<usize, NoSuccessor> {
        let Self {
            request,
            code,
            numbers,
            updates,
            successors,
            ..
        } = self;
        let mut next = from;
        while let Some((before, alternative)) = code.interpreted.get(next)
            && *before <= command
        {
            next += 1;
            let (grounded, layout) = (request.grounded, request.layout);
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
        Ok(next)
    }

    /// Counts the parts that commands without updates execute.
    fn cover(&mut self, state: &Words<W>) {
        let Self {
            pending,
            code,
            updates,
            ..
        } = self;
        for index in code.idle_index.held(state) {
            let Some(is_pending) = pending.get_mut(index).filter(|it| **it) else {
                continue;
            };
            *is_pending = false;
            let counters = code.idle.get(index).map_or(&[][..], |it| &it.counters);
            let count = |counter: &u32| updates.counts.get(*counter as usize).copied();
            if counters.iter().all(|it| count(it) != Some(0)) {
                continue;
            }
            for counter in counters {
                if let Some(count) = updates.counts.get_mut(*counter as usize) {
                    *count += 1;
                }
            }
        }
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
            self.read.clone_from(&self.known);
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
    pub fn counts(&self) -> Vec<u64> {
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

/// A successor.
#[derive(Clone, Copy, Debug)]
pub(crate) enum ReachedWords<const W: usize> {
    /// The state with this number.
    Known(u32),
    /// A state that was not known.
    Fresh(HashedState<W>),
}

/// The nodes that are known.
#[derive(Clone, Copy)]
pub(crate) struct KnownNodes<'a, const W: usize> {
    pub store: &'a WordStore<W>,
    /// If a state can be several nodes, the state and the inputs of each.
    pub cases: Option<&'a InputCases>,
    pub state_of: &'a Table<u32>,
    pub inputs_of: &'a Table<u32>,
    pub inputs: &'a [Vec<InputValue>],
}

impl<'a, const W: usize> KnownNodes<'a, W> {
    pub fn of(
        store: &'a WordStore<W>,
        cases: Option<&'a InputCases>,
        found: &'a Exploration,
    ) -> Self {
        Self {
            store,
            cases,
            state_of: &found.state_of,
            inputs_of: &found.inputs_of,
            inputs: &found.inputs,
        }
    }

    /// Returns the number of a node's state.
    pub fn state_of(&self, node: u32) -> u32 {
        match self.cases {
            None => node,
            Some(_) => self.state_of.get(node as usize).unwrap_or_default(),
        }
    }

    /// Gives the inputs of a node to its steps.
    pub fn give(&self, node: u32, steps: &mut GroundedSteps<'_, W>) {
        if let Some(cases) = self.cases {
            let at = self.inputs_of.get(node as usize).unwrap_or_default() as usize;
            if let (Some(numbers), Some(values)) = (cases.numbers.get(at), self.inputs.get(at)) {
                steps.give(numbers, values);
            }
        }
    }
}

/// The steps of one node.
#[derive(Debug)]
pub(crate) struct StateSteps {
    /// Index after the last of its successors in [`StepsOfStates::reached`].
    pub end: usize,
    pub updating: u64,
    pub is_idle: bool,
    /// `true` if no step changes the state, and none fails.
    pub rests: bool,
    pub failed: Vec<FailedStep>,
    pub stopped: Option<StoppedRun>,
}

/// The steps of consecutive states.
#[derive(Debug, Default)]
pub(crate) struct StepsOfStates<const W: usize> {
    pub states: Vec<StateSteps>,
    /// Successors; known ones are left out if transitions are not kept.
    pub reached: Vec<ReachedWords<W>>,
    /// Agents and rules that the step to each successor moves, if fairness refers to them.
    pub moved: Vec<MovedSet>,
}

impl<const W: usize> GroundedSteps<'_, W> {
    /// Finds the successors of consecutive nodes.
    pub fn find_all(
        &mut self,
        range: std::ops::Range<u32>,
        nodes: KnownNodes<'_, W>,
    ) -> StepsOfStates<W> {
        let known = nodes.store;
        let mut all = StepsOfStates {
            states: Vec::with_capacity(range.len()),
            reached: Vec::new(),
            moved: Vec::new(),
        };
        for number in range {
            let state = nodes.state_of(number);
            let state = known.get(state).unwrap_or([0; W]);
            nodes.give(number, self);
            let (failed, stopped) = match self.find(&state) {
                Ok(failed) => (failed, None),
                Err(stopped) => (Vec::new(), Some(stopped)),
            };
            let mut touched = 0;
            for next in &self.successors.states {
                touched |= known.touch(next.hash);
            }
            std::hint::black_box(touched);
            for (index, next) in self.successors.states.iter().enumerate() {
                let reached = match known.find(next) {
                    Ok(_) if !self.request.options.keeps_edges => continue,
                    Ok(number) => ReachedWords::Known(number),
                    Err(_) => ReachedWords::Fresh(*next),
                };
                all.reached.push(reached);
                if self.has_labels {
                    let moved = self.successors.moved.get(index).copied();
                    all.moved.push(moved.unwrap_or_default());
                }
            }
            all.states.push(StateSteps {
                end: all.reached.len(),
                updating: self.successors.updating,
                is_idle: self.successors.is_idle,
                rests: self.successors.rests,
                failed,
                stopped,
            });
        }
        all
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
