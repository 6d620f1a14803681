//! Runs that show a violation or a possibility, step by step.

use crate::decisions::{Decision, Decisions};
use crate::explore::Exploration;
use crate::exported_value::ExportedValue;
use crate::fair_moves::{CountsBefore, FairMoves, MovedSet};
use crate::system::VerifiedMachine;
use crate::transition::{MachineFault, TransitionSystem};
use asmotion_diagnostics::{Diagnostic, Span};
use asmotion_lang::guards::{PassedGuard, chosen_variables, guards_of};
use asmotion_lang::ir::Slot;
use asmotion_lang::simulate::{Trace, location, sent};
use asmotion_lang::{Machine, Value};

/// A run from an initial state.
#[derive(Clone, Debug, Default)]
pub struct Run {
    /// Locations of the initial state, with their values, sorted by machine and location. In a system of several machines, a
    /// location starts with the name of its machine, as in `courier.mode`.
    pub initial: Vec<(String, String)>,
    /// Steps of machines in order. In a system of several machines, a transition can consist of several of them: see
    /// [`RunStep::transition`].
    pub steps: Vec<RunStep>,
    /// Index of the step with which a cycle begins that the run repeats for ever; the cycle lasts until the last step.
    pub cycle: Option<usize>,
    /// Inputs in the last state that the property mentions.
    pub inputs: Vec<(String, String)>,
    /// A term that is false in the last state, if that alone violates the property.
    pub violated: Option<String>,
    /// The states before the first and after each transition that succeeds, sorted by machine and location, if they are kept.
    pub states: Vec<Vec<LocationValue>>,
    /// For each machine, the run in the format of `asmotion sim --trace`, which `asmotion sim --replay-inputs` repeats.
    pub traces: Vec<String>,
}

/// A location with its value.
#[derive(Clone, Debug, PartialEq)]
pub struct LocationValue {
    /// Name of the function; in a system of several machines with that of the machine, as in `courier.mode`.
    pub function: String,
    /// Arguments of the location.
    pub arguments: Vec<ExportedValue>,
    /// Value of the location.
    pub value: ExportedValue,
}

/// A step of a run.
#[derive(Clone, Debug, Default)]
pub struct RunStep {
    /// Index of the machine that makes the step, in [`Verification::machines`](crate::Verification::machines).
    pub machine: usize,
    /// Number of the transition that the step is part of, from 1. An environment and the machines that it surrounds move in one
    /// transition, and so do the machines of a synchronous system.
    pub transition: usize,
    /// Inputs that the step read, in order.
    pub inputs: Vec<(String, String)>,
    /// Choices, in order.
    pub choices: Vec<RunChoice>,
    /// Updates that change a location, sorted by location.
    pub updates: Vec<RunUpdate>,
    /// Events of messages before and after the step.
    pub messages: Vec<String>,
    /// The reason for which the step fails.
    pub fault: Option<Box<Diagnostic>>,
}

/// A choice of a step.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct RunChoice {
    /// Index of the candidate, from 0.
    pub index: usize,
    /// Number of candidates.
    pub count: usize,
    /// The variables of a `choose` rule with their values.
    pub values: Vec<(String, String)>,
    /// Place of the `choose` rule or term.
    pub place: Span,
}

/// A change of a location.
#[derive(Clone, Debug)]
pub struct RunUpdate {
    /// The location, as in `doing(ROB1, TASK1)`.
    pub location: String,
    /// Its value before the step.
    pub before: String,
    /// Its value after the step.
    pub after: String,
    /// Place of the update rule.
    pub place: Span,
    /// The guards on the way to the update rule, outermost first.
    pub guards: Vec<PassedGuard>,
}

/// A path through the nodes of an exploration.
#[derive(Clone, Debug, Default)]
pub(crate) struct NodePath {
    pub nodes: Vec<u32>,
    /// Decisions of the steps between the nodes, if they are known; otherwise the first ones that lead there.
    pub decisions: Vec<Vec<Decision>>,
    /// Agents and rules with fairness that the steps move, if it matters.
    pub moved: Vec<MovedSet>,
    /// Index of the node to which the last one leads back.
    pub cycle: Option<usize>,
    /// Decisions of a step that fails in the last node.
    pub failing: Option<Vec<Decision>>,
}

impl NodePath {
    /// The shortest path to a node.
    pub fn to(exploration: &Exploration, node: u32) -> Self {
        Self {
            nodes: exploration.path(node),
            ..Self::default()
        }
    }
}

/// Makes runs of paths.
pub(crate) struct Replay<'a, S> {
    pub machines: &'a [VerifiedMachine],
    pub exploration: &'a Exploration,
    /// System in the initial state.
    pub system: &'a S,
    pub fair: &'a FairMoves,
    pub keeps_states: bool,
}

impl<S: TransitionSystem> Replay<'_, S> {
    /// Executes a path.
    pub fn run(&self, path: &NodePath) -> Run {
        let concrete = if self.exploration.stands_for_others() {
            self.concrete(path)
        } else {
            None
        };
        let path = concrete.as_ref().unwrap_or(path);
        let mut system = self.system.clone();
        system.keep_candidates();
        let begin = |machine| Trace::begin(machine, "a run that `asmotion verify` found");
        let mut traces: Vec<Trace> = system.machines().iter().map(begin).collect();
        let mut run = Run {
            initial: self.locations(&system),
            ..Run::default()
        };
        let back = path.cycle.and_then(|index| path.nodes.get(index));
        let ends = path.nodes.iter().skip(1).chain(back);
        let mut stopped = None;
        if let Some(first) = path.nodes.first() {
            self.begin(&mut system, *first, &mut traces, &mut run);
        }
        run.states = self.state(&system);
        for (index, (from, to)) in path.nodes.iter().zip(ends).enumerate() {
            if path.cycle == Some(index) {
                run.cycle = Some(run.steps.len());
            }
            let known = path.decisions.get(index).cloned();
            let moved = path.moved.get(index).copied();
            let Some(decisions) = known.or_else(|| self.decisions(*from, *to, moved)) else {
                break;
            };
            self.step(&mut system, *from, &decisions, &mut traces, &mut run);
        }
        if path.cycle.is_some() && run.cycle.is_none() {
            run.cycle = Some(run.steps.len());
        }
        if let (Some(decisions), Some(last)) = (&path.failing, path.nodes.last()) {
            stopped = self.step(&mut system, *last, decisions, &mut traces, &mut run);
        }
        if let (None, Some(last)) = (path.cycle, path.nodes.last()) {
            let inputs = self.exploration.inputs(*last).iter();
            let shown = inputs.filter_map(|input| {
                let machine = system.machines().get(input.machine)?;
                let naming = machine.naming();
                let name =
                    asmotion_lang::simulate::applied(machine, input.function, &input.arguments);
                let name = self.qualified(input.machine, name);
                Some((name, input.value.show(&naming).to_string()))
            });
            run.inputs = shown.collect();
        }
        let traces = traces.into_iter().zip(system.machines()).enumerate();
        run.traces = traces
            .map(|(index, (trace, machine))| {
                let fault = stopped.as_ref().filter(|it| it.machine == index);
                trace.end(machine, fault.and_then(MachineFault::step))
            })
            .collect();
        run
    }

    /// Enters an initial state. The steps of an environment are part of the first transition.
    fn begin(&self, system: &mut S, node: u32, traces: &mut [Trace], run: &mut Run) {
        let wanted = self.exploration.state_number(node);
        let machines = system.machines().to_vec();
        let mut before = Vec::new();
        system.pack(&mut before);
        let decisions = Decisions::default();
        let mut packed = Vec::new();
        loop {
            let done = system.begin(&decisions);
            packed.clear();
            system.pack(&mut packed);
            let is_it = self.exploration.number_of(system, &packed) == wanted;
            if done.is_err() || is_it || !decisions.advance() {
                break;
            }
            system.restore(&before);
        }
        let moved = system.moved().iter();
        if moved.clone().all(|index| system.prepares_next(*index)) {
            self.show(system, &machines, (0, None), traces, run);
        }
    }

    /// Returns the first decisions that lead from a node to another, by a transition that moves this.
    fn decisions(&self, from: u32, to: u32, wanted: Option<MovedSet>) -> Option<Vec<Decision>> {
        let mut system = self.system.clone();
        if self.fair.has_agents() {
            system.keep_candidates();
        }
        let (from_state, to_state) = (self.exploration.state(from), self.exploration.state(to));
        let decisions = Decisions::default();
        let mut counts = CountsBefore::default();
        let mut packed = Vec::new();
        loop {
            system.restore(&from_state);
            self.fair.before(&system, &mut counts);
            let done = system.step(&decisions, self.exploration.inputs(from));
            packed.clear();
            system.pack(&mut packed);
            let moved = self.fair.moved(&system, &counts, *packed != *from_state);
            let is_meant = wanted.is_none_or(|wanted| wanted == moved);
            if done.is_ok() && *packed == *to_state && is_meant {
                return Some(decisions.taken());
            }
            if !decisions.advance() {
                return None;
            }
        }
    }

    /// Executes a transition and appends its steps to the run. Returns the fault of a step that fails.
    fn step(
        &self,
        system: &mut S,
        node: u32,
        taken: &[Decision],
        traces: &mut [Trace],
        run: &mut Run,
    ) -> Option<MachineFault> {
        let decisions = Decisions::default();
        decisions.repeat(taken);
        let before = system.machines().to_vec();
        let done = system.step(&decisions, self.exploration.inputs(node));
        let fault = done.err();
        if fault.is_none() {
            run.states.extend(self.state(system));
        }
        let steps = run.steps.iter();
        let earlier = steps.filter(|step| !system.prepares_next(step.machine));
        let transition = earlier.map(|step| step.transition).max().unwrap_or(0) + 1;
        self.show(system, &before, (transition, fault.as_ref()), traces, run);
        fault
    }

    /// Appends the steps that the system has made to a run. `before` are the machines before the transition.
    fn show(
        &self,
        system: &S,
        before: &[Machine],
        (transition, fault): (usize, Option<&MachineFault>),
        traces: &mut [Trace],
        run: &mut Run,
    ) {
        let mut events = system.events().to_vec();
        for &index in system.moved() {
            let Some(machine) = system.machines().get(index) else {
                continue;
            };
            let fault = fault.filter(|it| it.machine == index);
            if let Some(trace) = traces.get_mut(index) {
                match fault.and_then(MachineFault::step) {
                    None => trace.step(machine),
                    Some(fault) => trace.fault(machine, fault),
                }
            }
            let transition = transition + usize::from(system.prepares_next(index));
            let mut step = self.shown(index, machine, transition, fault);
            step.messages.append(&mut events);
            if let Some(before) = before.get(index) {
                self.add_guards(&mut step, machine, before);
            }
            run.steps.push(step);
        }
    }

    fn shown(
        &self,
        index: usize,
        machine: &Machine,
        transition: usize,
        fault: Option<&MachineFault>,
    ) -> RunStep {
        let specification = self.machines.get(index).map(|it| &it.specification);
        let place = |origin| specification.map_or_else(Span::default, |known| known.span(origin));
        let naming = machine.naming();
        let show = |value: &Value| value.show(&naming).to_string();
        let step = machine.last_step();
        let inputs = step.inputs().iter();
        let inputs = inputs.map(|input| (location(machine, input.slot), show(&input.value)));
        let choices = step.choices().iter().enumerate();
        let choices = choices.map(|(number, choice)| {
            let place = place(choice.origin);
            let variables = specification.map(|known| chosen_variables(known, place));
            let mut candidates = step.candidates().iter();
            let candidate = candidates.find(|it| it.choice == Some(number));
            let values = candidate.map(|it| it.values.as_slice()).unwrap_or_default();
            let values = variables.unwrap_or_default().into_iter().zip(values);
            RunChoice {
                index: choice.index,
                count: choice.count,
                values: values.map(|(name, value)| (name, show(value))).collect(),
                place,
            }
        });
        let mut updates: Vec<RunUpdate> = Vec::new();
        for (update, before) in step.updates().iter().zip(step.before()) {
            if update.value != *before {
                updates.push(RunUpdate {
                    location: location(machine, update.slot),
                    before: show(before),
                    after: show(&update.value),
                    place: place(update.origin),
                    guards: Vec::new(),
                });
            }
        }
        updates.sort_by(|left, right| left.location.cmp(&right.location));
        let explained = fault.and_then(|fault| {
            let diagnostic = fault.diagnostic(specification?, Some(machine));
            Some(Box::new(diagnostic))
        });
        RunStep {
            machine: index,
            transition,
            inputs: inputs.collect(),
            choices: choices.collect(),
            updates,
            messages: step.sent().iter().map(|it| sent(machine, it)).collect(),
            fault: explained,
        }
    }

    /// Adds the guards of the updates of a step. `before` is the machine before the step.
    fn add_guards(&self, step: &mut RunStep, machine: &Machine, before: &Machine) {
        let specification = self
            .machines
            .get(step.machine)
            .map(|known| &known.specification);
        let (Some(account), Some(specification)) = (machine.account(before), specification) else {
            return;
        };
        let naming = machine.naming();
        let show = |value: &Value| value.show(&naming).to_string();
        for update in machine.last_step().updates() {
            let name = location(machine, update.slot);
            if let Some(known) = step.updates.iter_mut().find(|it| it.location == name) {
                known.guards = guards_of(specification, &account, update, &show);
            }
        }
    }

    /// Returns the locations of the specifications that rules update, with their values.
    fn locations(&self, system: &S) -> Vec<(String, String)> {
        let machines = system.machines().iter().enumerate();
        let all = machines.flat_map(|(index, machine)| {
            let locations = locations(machine).into_iter();
            locations.map(move |(name, value)| (self.qualified(index, name), value))
        });
        all.collect()
    }

    /// Returns the state, if states are kept.
    fn state(&self, system: &S) -> Vec<Vec<LocationValue>> {
        if !self.keeps_states {
            return Vec::new();
        }
        let mut all = Vec::new();
        for (index, machine) in system.machines().iter().enumerate() {
            let (state, program, naming) = (machine.state(), machine.program(), machine.naming());
            let mut locations = Vec::new();
            for slot in state.slots().filter(|slot| is_shown(machine, *slot)) {
                if let Some((function, arguments)) = state.location(program, slot) {
                    let named = |value: &Value| ExportedValue::of(value, &naming);
                    let symbols = &program.symbols.functions;
                    let name = symbols.get(function.0 as usize);
                    let name = name.map_or_else(String::new, ToString::to_string);
                    let shown = LocationValue {
                        function: self.qualified(index, name),
                        arguments: arguments.iter().map(named).collect(),
                        value: named(state.get(slot)),
                    };
                    locations.push((location(machine, slot), shown));
                }
            }
            locations.sort_by(|left, right| left.0.cmp(&right.0));
            all.extend(locations.into_iter().map(|(_, shown)| shown));
        }
        vec![all]
    }

    /// Returns the name of a location, with that of its machine if there are several.
    fn qualified(&self, machine: usize, name: String) -> String {
        match self.machines.get(machine) {
            Some(known) if self.machines.len() > 1 => format!("{}.{name}", known.name),
            Some(_) | None => name,
        }
    }
}

/// Returns `true` for the locations of the specification that rules update.
fn is_shown(machine: &Machine, slot: Slot) -> bool {
    use asmotion_lang::ir::FunctionKind;
    let program = machine.program();
    let function = machine.state().function(program, slot);
    let function = function.and_then(|id| program.functions.get(id.0 as usize));
    function.is_some_and(|it| {
        it.own
            && matches!(
                it.kind,
                FunctionKind::Controlled | FunctionKind::Out | FunctionKind::Shared
            )
    })
}

/// Returns the locations of the specification that rules update, with their values.
fn locations(machine: &Machine) -> Vec<(String, String)> {
    let (state, naming) = (machine.state(), machine.naming());
    let shown = state.slots().filter(|slot| is_shown(machine, *slot));
    let mut all: Vec<(String, String)> = shown
        .map(|slot| {
            (
                location(machine, slot),
                state.get(slot).show(&naming).to_string(),
            )
        })
        .collect();
    all.sort();
    all
}
