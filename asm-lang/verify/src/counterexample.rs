//! Runs that show a violation or a possibility, step by step.

use crate::decisions::{DecidedChoices, DecidedInputs, Decision, Decisions};
use crate::explore::Exploration;
use crate::inputs::InputRanges;
use asmotion_diagnostics::{Diagnostic, Span};
use asmotion_lang::simulate::{Trace, location};
use asmotion_lang::{Machine, Specification, StepFault, Value};

/// A run from an initial state.
#[derive(Clone, Debug, Default)]
pub struct Run {
    /// Locations of the initial state, with their values, sorted by location.
    pub initial: Vec<(String, String)>,
    /// Steps in order.
    pub steps: Vec<RunStep>,
    /// Index of the step with which a cycle begins that the run repeats for ever; the cycle lasts until the last step.
    pub cycle: Option<usize>,
    /// Inputs in the last state that the property mentions.
    pub inputs: Vec<(String, String)>,
    /// The run in the format of `asmotion sim --trace`, which `asmotion sim --replay-inputs` repeats.
    pub trace: String,
}

/// A step of a run.
#[derive(Clone, Debug, Default)]
pub struct RunStep {
    /// Inputs that the step read, in order.
    pub inputs: Vec<(String, String)>,
    /// Choices: index, number of candidates, and place.
    pub choices: Vec<(usize, usize, Span)>,
    /// Updates that change a location, sorted by location.
    pub updates: Vec<RunUpdate>,
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
            cycle: None,
            failing: None,
        }
    }
}

/// Makes runs of paths.
pub(crate) struct Replay<'a> {
    pub specification: &'a Specification,
    pub exploration: &'a Exploration,
    pub ranges: &'a InputRanges,
    /// Machine in the initial state.
    pub machine: &'a Machine,
}

impl Replay<'_> {
    /// Executes a path.
    pub fn run(&self, path: &NodePath) -> Run {
        let mut machine = self.machine.clone();
        let mut trace = Trace::begin(&machine, "a run that `asmotion verify` found");
        let mut run = Run {
            initial: locations(&machine),
            cycle: path.cycle,
            ..Run::default()
        };
        let back = path.cycle.and_then(|index| path.nodes.get(index));
        let ends = path.nodes.iter().skip(1).chain(back);
        let mut stopped = None;
        for (from, to) in path.nodes.iter().zip(ends) {
            let Some(decisions) = self.decisions(*from, *to) else {
                break;
            };
            let (step, _) = self.step(&mut machine, *from, &decisions, &mut trace);
            run.steps.push(step);
        }
        if let (Some(decisions), Some(last)) = (&path.failing, path.nodes.last()) {
            let (step, fault) = self.step(&mut machine, *last, decisions, &mut trace);
            stopped = fault;
            run.steps.push(step);
        }
        if let (None, Some(last)) = (path.cycle, path.nodes.last()) {
            let inputs = self.exploration.inputs(*last).iter();
            let shown = inputs.map(|input| {
                let naming = machine.naming();
                let name =
                    asmotion_lang::simulate::applied(&machine, input.function, &input.arguments);
                (name, input.value.show(&naming).to_string())
            });
            run.inputs = shown.collect();
        }
        run.trace = trace.end(&machine, stopped.as_deref());
        run
    }

    /// Returns the first decisions that lead from a node to another.
    fn decisions(&self, from: u32, to: u32) -> Option<Vec<Decision>> {
        let mut machine = self.machine.clone();
        let (from_state, to_state) = (self.exploration.state(from), self.exploration.state(to));
        let decisions = Decisions::default();
        let mut packed = Vec::new();
        loop {
            machine.restore_state(from_state).ok()?;
            let done = self.execute(&mut machine, from, &decisions);
            packed.clear();
            machine.pack_state(&mut packed);
            if done.is_ok() && packed == to_state {
                return Some(decisions.taken());
            }
            if !decisions.advance() {
                return None;
            }
        }
    }

    fn execute(
        &self,
        machine: &mut Machine,
        node: u32,
        decisions: &Decisions,
    ) -> Result<(), Box<StepFault>> {
        let mut inputs = DecidedInputs {
            decisions,
            ranges: self.ranges,
            known: self.exploration.inputs(node),
        };
        let mut choices = DecidedChoices(decisions);
        machine.step(&mut inputs, &mut choices, 0).map(|_| ())
    }

    fn step(
        &self,
        machine: &mut Machine,
        node: u32,
        taken: &[Decision],
        trace: &mut Trace,
    ) -> (RunStep, Option<Box<StepFault>>) {
        let decisions = Decisions::default();
        decisions.repeat(taken);
        let done = self.execute(machine, node, &decisions);
        match &done {
            Ok(()) => trace.step(machine),
            Err(fault) => trace.fault(machine, fault),
        }
        let naming = machine.naming();
        let show = |value: &Value| value.show(&naming).to_string();
        let step = machine.last_step();
        let inputs = step.inputs().iter();
        let inputs = inputs.map(|input| (location(machine, input.slot), show(&input.value)));
        let choices = step.choices().iter();
        let choices = choices.map(|it| (it.index, it.count, self.specification.span(it.origin)));
        let mut updates: Vec<RunUpdate> = Vec::new();
        for (update, before) in step.updates().iter().zip(step.before()) {
            if update.value != *before {
                updates.push(RunUpdate {
                    location: location(machine, update.slot),
                    before: show(before),
                    after: show(&update.value),
                    place: self.specification.span(update.origin),
                });
            }
        }
        updates.sort_by(|left, right| left.location.cmp(&right.location));
        let fault = done.err();
        let explained = fault.as_deref();
        let explained = explained.map(|it| Box::new(self.specification.explain_in(it, machine)));
        let step = RunStep {
            inputs: inputs.collect(),
            choices: choices.collect(),
            updates,
            fault: explained,
        };
        (step, fault)
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
