//! Runs that show a violation or a possibility, step by step.

use crate::decisions::{Decision, Decisions};
use crate::explore::Exploration;
use crate::system::VerifiedMachine;
use crate::transition::{MachineFault, TransitionSystem};
use asmotion_diagnostics::{Diagnostic, Span};
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
    /// For each machine, the run in the format of `asmotion sim --trace`, which `asmotion sim --replay-inputs` repeats.
    pub traces: Vec<String>,
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
    /// Choices: index, number of candidates, and place.
    pub choices: Vec<(usize, usize, Span)>,
    /// Updates that change a location, sorted by location.
    pub updates: Vec<RunUpdate>,
    /// What happened to messages before and after the step.
    pub messages: Vec<String>,
    /// The reason for which the step fails.
    pub fault: Option<Box<Diagnostic>>,
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
}

/// A path through the nodes of an exploration.
#[derive(Clone, Debug, Default)]
pub(crate) struct NodePath {
    pub nodes: Vec<u32>,
    /// Labels of the transitions, as far as they matter.
    pub labels: Vec<Option<u32>>,
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
            labels: Vec::new(),
            cycle: None,
            failing: None,
        }
    }
}

/// Makes runs of paths.
pub(crate) struct Replay<'a, S> {
    pub machines: &'a [VerifiedMachine],
    pub exploration: &'a Exploration,
    /// System in the initial state.
    pub system: &'a S,
}

impl<S: TransitionSystem> Replay<'_, S> {
    /// Executes a path.
    pub fn run(&self, path: &NodePath) -> Run {
        let mut system = self.system.clone();
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
        for (index, (from, to)) in path.nodes.iter().zip(ends).enumerate() {
            if path.cycle == Some(index) {
                run.cycle = Some(run.steps.len());
            }
            let label = path.labels.get(index).copied().flatten();
            let Some(decisions) = self.decisions(*from, *to, label) else {
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
        let wanted = self.exploration.state(node);
        let mut before = Vec::new();
        system.pack(&mut before);
        let decisions = Decisions::default();
        let mut packed = Vec::new();
        loop {
            let done = system.begin(&decisions);
            packed.clear();
            system.pack(&mut packed);
            if done.is_err() || packed == wanted || !decisions.advance() {
                break;
            }
            system.restore(&before);
        }
        let moved = system.moved().iter();
        if moved.clone().all(|index| system.prepares_next(*index)) {
            self.show(system, 0, None, traces, run);
        }
    }

    /// Returns the first decisions that lead from a node to another, by a transition with this label.
    fn decisions(&self, from: u32, to: u32, label: Option<u32>) -> Option<Vec<Decision>> {
        let mut system = self.system.clone();
        let (from_state, to_state) = (self.exploration.state(from), self.exploration.state(to));
        let decisions = Decisions::default();
        let mut packed = Vec::new();
        loop {
            system.restore(from_state);
            let done = system.step(&decisions, self.exploration.inputs(from));
            packed.clear();
            system.pack(&mut packed);
            let is_meant = label.is_none_or(|label| system.label() == label);
            if done.is_ok() && packed == to_state && is_meant {
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
        let done = system.step(&decisions, self.exploration.inputs(node));
        let fault = done.err();
        let steps = run.steps.iter();
        let before = steps.filter(|step| !system.prepares_next(step.machine));
        let transition = before.map(|step| step.transition).max().unwrap_or(0) + 1;
        self.show(system, transition, fault.as_ref(), traces, run);
        fault
    }

    /// Appends the steps that the system has made to a run.
    fn show(
        &self,
        system: &S,
        transition: usize,
        fault: Option<&MachineFault>,
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
        let choices = step.choices().iter();
        let choices = choices.map(|it| (it.index, it.count, place(it.origin)));
        let mut updates: Vec<RunUpdate> = Vec::new();
        for (update, before) in step.updates().iter().zip(step.before()) {
            if update.value != *before {
                updates.push(RunUpdate {
                    location: location(machine, update.slot),
                    before: show(before),
                    after: show(&update.value),
                    place: place(update.origin),
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

    /// Returns the locations of the specifications that rules update, with their values.
    fn locations(&self, system: &S) -> Vec<(String, String)> {
        let machines = system.machines().iter().enumerate();
        let all = machines.flat_map(|(index, machine)| {
            let locations = locations(machine).into_iter();
            locations.map(move |(name, value)| (self.qualified(index, name), value))
        });
        all.collect()
    }

    /// Returns the name of a location, with that of its machine if there are several.
    fn qualified(&self, machine: usize, name: String) -> String {
        match self.machines.get(machine) {
            Some(known) if self.machines.len() > 1 => format!("{}.{name}", known.name),
            Some(_) | None => name,
        }
    }
}

/// Returns the locations of the specification that rules update, with their values.
fn locations(machine: &Machine) -> Vec<(String, String)> {
    use asmotion_lang::ir::FunctionKind;
    let (state, program, naming) = (machine.state(), machine.program(), machine.naming());
    let shown = state.slots().filter(|slot| {
        let function = state.function(program, *slot);
        let function = function.and_then(|id| program.functions.get(id.0 as usize));
        function.is_some_and(|it| {
            it.own
                && matches!(
                    it.kind,
                    FunctionKind::Controlled | FunctionKind::Out | FunctionKind::Shared
                )
        })
    });
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
