//! The successors of nodes, found without changing what is known of the exploration, so that several threads can find those of
//! different nodes at the same time. The explorer then takes them over in the order of the nodes: see [`explorer`](crate::explorer).

use crate::decisions::{Decision, Decisions, InputValue, MAX_EXECUTIONS};
use crate::explore::{Conditions, Exploration, ExplorationError, Limits};
use crate::fair_moves::{CountsBefore, FairMoves, MovedSet};
use crate::round_limits::ExaminedLimits;
use crate::store::StateStore;
use crate::transition::{MachineFault, TransitionSystem};
use asmotion_lang::Value;

/// A node that is to be explored.
#[derive(Debug, Default)]
pub(crate) struct NodeToExpand {
    /// The bytes of its state.
    pub state: Vec<u8>,
    /// Its inputs.
    pub inputs: Vec<InputValue>,
}

/// A state to which a step leads.
#[derive(Clone, Copy, Debug)]
pub(crate) enum ReachedState {
    /// A state with this number.
    Known(u32),
    /// A state that was not known, with this index in [`Expansions::fresh`].
    Fresh(u32),
}

/// The outcome of an execution of a step.
#[derive(Debug)]
pub(crate) enum StepOutcome {
    /// A state, and what the step moves, if fairness refers to it.
    Reached(ReachedState, MovedSet),
    /// No state.
    Failed(Vec<Decision>, MachineFault),
    /// The exploration cannot continue.
    Stopped(ExplorationError),
}

/// The successors of one node.
#[derive(Debug, Default)]
pub(crate) struct NodeSuccessors {
    /// The outcomes of the executions, in order. Known states are left out if transitions are not kept.
    pub outcomes: Vec<StepOutcome>,
    /// Number of executions that update a location.
    pub updating: u64,
    /// Number of executions, and of evaluations of the conditions in fresh states.
    pub executions: u64,
    /// `true` if no step changes anything.
    pub rests: bool,
    /// `true` if a state was left out because of the elements in it.
    pub lacks_elements: bool,
}

/// The value of the conditions in a state, for one combination of the inputs that they read.
#[derive(Debug)]
pub(crate) struct ObservedCase {
    /// `false` if an assumption excludes the combination; the rest is then empty.
    pub is_considered: bool,
    pub inputs: Vec<InputValue>,
    /// Truth of each condition; `None` for undef.
    pub truths: Vec<Option<bool>>,
}

impl ObservedCase {
    /// Returns the memory that it takes, in bytes, with the arguments of each input and what the allocator adds.
    fn memory(&self) -> usize {
        let inputs = self.inputs.len() * (size_of::<InputValue>() + 2 * size_of::<Value>());
        size_of::<Self>() + inputs + self.truths.len() + 32
    }
}

/// The value of the conditions in a state.
#[derive(Debug, Default)]
pub(crate) struct Observation {
    pub cases: Vec<ObservedCase>,
    /// Conditions whose evaluation fails.
    pub failed: Vec<(usize, MachineFault)>,
    pub stopped: Option<ExplorationError>,
}

/// The successors of several nodes.
#[derive(Debug, Default)]
pub(crate) struct Expansions {
    pub nodes: Vec<NodeSuccessors>,
    /// The states that were not known.
    pub fresh: StateStore,
    /// The value of the conditions in each of these states.
    pub observations: Vec<Observation>,
    /// Number of combinations of inputs in all observations.
    cases: u64,
}

/// The part of an exploration that is known while nodes are expanded.
#[derive(Clone, Copy)]
pub(crate) struct KnownStates<'a> {
    pub states: &'a StateStore,
    pub keeps_edges: bool,
}

impl<'a> KnownStates<'a> {
    pub fn of(exploration: &'a Exploration) -> Self {
        Self {
            states: &exploration.states,
            keeps_edges: exploration.keeps_edges,
        }
    }
}

/// Executes the steps of nodes, with a system of its own.
pub(crate) struct Expander<'a, S> {
    pub system: S,
    pub conditions: &'a Conditions,
    pub limits: Limits,
    pub fair: &'a FairMoves,
    /// `true` if fairness refers to the labels of transitions.
    pub has_labels: bool,
    counts: CountsBefore,
    decisions: Decisions,
    values: Vec<Value>,
    packed: Vec<u8>,
    /// State of the node that is being explored, and of its successor, without the environment.
    own_before: Vec<u8>,
    own: Vec<u8>,
    /// `true` if a part of the state belongs to the environment.
    pub has_surroundings: bool,
}

impl<'a, S: TransitionSystem> Expander<'a, S> {
    pub fn new(
        system: S,
        conditions: &'a Conditions,
        limits: Limits,
        fair: &'a FairMoves,
        has_labels: bool,
    ) -> Self {
        Self {
            has_surroundings: system.has_surroundings(),
            system,
            conditions,
            limits,
            fair,
            has_labels,
            counts: CountsBefore::default(),
            decisions: Decisions::default(),
            values: Vec::new(),
            packed: Vec::new(),
            own_before: Vec::new(),
            own: Vec::new(),
        }
    }

    /// Returns an expander for another thread.
    pub fn another(&self) -> Self {
        let Self {
            system,
            conditions,
            limits,
            fair,
            has_labels,
            ..
        } = self;
        Self::new(system.clone(), conditions, *limits, fair, *has_labels)
    }

    /// Returns the initial states as fresh ones, in the order in which they are found; all of them, unless a limit ends the search.
    pub fn begin(
        &mut self,
        limits: &mut ExaminedLimits<'_>,
    ) -> Result<Expansions, ExplorationError> {
        let mut found = Expansions::default();
        let mut before = Vec::new();
        self.system.pack(&mut before);
        let decisions = Decisions::default();
        loop {
            if let Err(fault) = self.system.begin(&decisions) {
                return Err(if fault.is_of_input() {
                    ExplorationError::Input(fault)
                } else {
                    ExplorationError::Initial(fault)
                });
            }
            self.packed.clear();
            self.system.pack(&mut self.packed);
            self.fresh(&mut found, limits);
            if !decisions.advance() || !limits.goes_on(0) {
                return Ok(found);
            }
            self.system.restore(&before);
        }
    }

    /// Finds the successors of a node; all of them, unless a limit ends the round.
    pub fn expand(
        &mut self,
        at: &NodeToExpand,
        known: KnownStates<'_>,
        to: &mut Expansions,
        limits: &mut ExaminedLimits<'_>,
    ) {
        let mut found = NodeSuccessors {
            rests: true,
            ..NodeSuccessors::default()
        };
        self.system.restore(&at.state);
        if self.system.has_ended() {
            found.rests = false;
            to.nodes.push(found);
            return;
        }
        self.decisions.restart();
        self.own_before.clear();
        self.system.pack_own(&mut self.own_before);
        let mut executions = 0;
        loop {
            executions += 1;
            if executions > MAX_EXECUTIONS {
                let stopped = StepOutcome::Stopped(ExplorationError::Alternatives);
                found.outcomes.push(stopped);
                break;
            }
            if !limits.goes_on(size_of::<StepOutcome>()) {
                break;
            }
            let can_revert = self.system.can_revert();
            self.fair.before(&self.system, &mut self.counts);
            match self.system.step(&self.decisions, &at.inputs) {
                Ok(_) if self.exceeds_reserve() => {
                    found.rests = false;
                    found.lacks_elements = true;
                }
                Ok(has_updates) => {
                    found.updating += u64::from(has_updates);
                    self.reached(&at.state, known, &mut found, to, limits);
                }
                Err(fault) => {
                    found.rests = false;
                    let failed = StepOutcome::Failed(self.decisions.taken(), fault);
                    found.outcomes.push(failed);
                }
            }
            if !self.decisions.advance() {
                break;
            }
            if can_revert {
                self.system.revert();
            } else {
                self.system.restore(&at.state);
            }
        }
        found.executions += executions;
        to.nodes.push(found);
    }

    /// Takes the state in which the system is after a step.
    fn reached(
        &mut self,
        before: &[u8],
        known: KnownStates<'_>,
        found: &mut NodeSuccessors,
        to: &mut Expansions,
        limits: &mut ExaminedLimits<'_>,
    ) {
        self.packed.clear();
        self.system.pack(&mut self.packed);
        let is_changed = self.packed != before;
        found.rests &= if self.has_surroundings {
            self.own.clear();
            self.system.pack_own(&mut self.own);
            self.own == self.own_before
        } else {
            !is_changed
        };
        let moved = if self.has_labels {
            self.fair.moved(&self.system, &self.counts, is_changed)
        } else {
            0
        };
        let state = match known.states.find(&self.packed) {
            Some(_) if !known.keeps_edges => return,
            Some(number) => ReachedState::Known(number),
            None => {
                let before = to.cases;
                let index = self.fresh(to, limits);
                found.executions += to.cases - before;
                ReachedState::Fresh(index)
            }
        };
        found.outcomes.push(StepOutcome::Reached(state, moved));
    }

    /// Adds the state in `packed`, in which the system is, to the fresh ones; returns its index.
    fn fresh(&mut self, to: &mut Expansions, limits: &mut ExaminedLimits<'_>) -> u32 {
        let (index, is_new) = to.fresh.add(&self.packed).unwrap_or_default();
        if is_new {
            let observation = self.observe(limits);
            to.cases += observation.cases.len() as u64;
            to.observations.push(observation);
        }
        index
    }

    /// Returns `true` if a machine has created more elements than permitted.
    fn exceeds_reserve(&self) -> bool {
        let limit = self.limits.reserve;
        limit.is_some_and(|limit| {
            let mut machines = self.system.machines().iter();
            machines.any(|machine| machine.naming().reserve.len() > limit)
        })
    }

    /// Evaluates the conditions in the current state, for each combination of inputs that they read.
    fn observe(&mut self, limits: &mut ExaminedLimits<'_>) -> Observation {
        let mut observation = Observation::default();
        if self.conditions.terms.is_empty() {
            observation.cases.push(ObservedCase {
                is_considered: true,
                inputs: Vec::new(),
                truths: Vec::new(),
            });
            return observation;
        }
        let decisions = Decisions::default();
        let mut combinations = 0;
        loop {
            combinations += 1;
            if combinations > MAX_EXECUTIONS {
                observation.stopped = Some(ExplorationError::Alternatives);
                return observation;
            }
            if let Err(error) = self.evaluate(&decisions, &mut observation.failed) {
                observation.stopped = Some(error);
                return observation;
            }
            let is_true = |index: &usize| self.values.get(*index) == Some(&Value::Bool(true));
            let is_considered = self.conditions.assumed.iter().all(is_true);
            let truth = |value: &Value| (!value.is_undef()).then(|| *value == Value::Bool(true));
            observation.cases.push(if is_considered {
                ObservedCase {
                    is_considered,
                    inputs: decisions.read(),
                    truths: self.values.iter().map(truth).collect(),
                }
            } else {
                ObservedCase {
                    is_considered,
                    inputs: Vec::new(),
                    truths: Vec::new(),
                }
            });
            let bytes = observation.cases.last().map_or(0, ObservedCase::memory);
            if !limits.goes_on(bytes) || !decisions.advance() {
                return observation;
            }
        }
    }

    /// Evaluates the conditions into `values`; one whose evaluation fails is undef.
    fn evaluate(
        &mut self,
        decisions: &Decisions,
        failed: &mut Vec<(usize, MachineFault)>,
    ) -> Result<(), ExplorationError> {
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
                if failed.iter().all(|(known, _)| *known != index) {
                    failed.push((index, fault));
                }
                self.values.push(Value::Undef);
            }
        }
        Ok(())
    }
}
