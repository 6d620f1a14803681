//! Runs of composites as runs of the verified specification alone: with all values of its inputs, as its environment has set them.

use super::{Verify, avalla, itf, run_files};
use crate::exit::Exit;
use crate::terminal::TerminalOutput;
use crate::verification::is_own;
use asmotion_lang::ir::FunctionId;
use asmotion_lang::simulate::Trace;
use asmotion_lang::{Chooser, Environment, Report, Session, Sources, Specification, Value};
use asmotion_verification::ModelledEnvironment;
use asmotion_verify::{CheckedProperty, Run, RunStep, Verification, VerifiedMachine};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// A run of the verified specification, and the same run with the state of its environment.
pub struct ProjectedRun {
    pub property: CheckedProperty,
    /// Inputs, choices and updates of the verified specification.
    pub own: Run,
    /// All locations, those of the environment included.
    pub whole: Run,
}

impl ProjectedRun {
    /// Returns the run that shows the first violation, or else a possibility.
    pub fn of(verification: &Verification, environment: &ModelledEnvironment) -> Option<Self> {
        let (property, run) = run_files::shown(verification)?;
        let sources = &verification.machines.first()?.specification.sources;
        Some(Self {
            property: property.clone(),
            own: projected(run, environment, sources),
            whole: run.clone(),
        })
    }
}

/// Returns the part of a run that concerns the verified specification.
fn projected(run: &Run, environment: &ModelledEnvironment, sources: &Sources) -> Run {
    let function_of = |location: &str| {
        let end = location.find('(').unwrap_or(location.len());
        location.get(..end).unwrap_or(location).to_owned()
    };
    let is_input = |location: &String| environment.inputs.contains_key(location);
    let is_own_location = |location: &String| {
        !is_input(location) && environment.functions.contains(&function_of(location))
    };
    let mut inputs: BTreeMap<String, String> = environment.inputs.clone();
    let set = |inputs: &mut BTreeMap<String, String>, location: &String, value: &String| {
        if is_input(location) {
            inputs.insert(location.clone(), value.clone());
        }
    };
    for (location, value) in &run.initial {
        set(&mut inputs, location, value);
    }
    let mut own = Run {
        initial: run.initial.clone(),
        cycle: run.cycle,
        violated: run.violated.clone(),
        ..Run::default()
    };
    own.initial
        .retain(|(location, _)| is_own_location(location));
    for step in &run.steps {
        let mut shown = RunStep {
            machine: 0,
            transition: step.transition,
            inputs: inputs.clone().into_iter().collect(),
            fault: step.fault.clone(),
            ..RunStep::default()
        };
        shown.inputs.extend(step.inputs.iter().cloned());
        let choices = step.choices.iter();
        let choices = choices.filter(|it| is_own(it.place, sources, environment));
        shown.choices.extend(choices.cloned());
        let updates = step.updates.iter();
        let updates = updates.filter(|it| is_own_location(&it.location));
        shown.updates.extend(updates.cloned());
        own.steps.push(shown);
        for update in &step.updates {
            set(&mut inputs, &update.location, &update.after);
        }
    }
    own.inputs = inputs.into_iter().collect();
    own.inputs.extend(run.inputs.iter().cloned());
    own
}

impl Verify {
    /// Writes a run of the specification of a component to the files that were requested.
    pub(super) fn write_projected(
        &self,
        run: Option<&ProjectedRun>,
        environment: &ModelledEnvironment,
        machines: &[VerifiedMachine],
        terminal: &mut TerminalOutput,
    ) -> Exit {
        if !self.has_exports() {
            return Exit::Ok;
        }
        let Some(run) = run else {
            self.nothing_to_write(terminal);
            return Exit::Ok;
        };
        let specification = match self.open(&environment.file, self.init.clone(), terminal) {
            Ok(specification) => specification,
            Err(exit) => return exit,
        };
        let mut files: Vec<(PathBuf, String)> = Vec::new();
        if let Some(path) = &self.avalla {
            let paths = (path.as_path(), Path::new(&environment.file));
            let scenario = avalla::scenario(&run.property, &run.own, &specification, paths);
            files.push((path.clone(), scenario));
        }
        if let Some(path) = &self.itf {
            let trace = itf::trace(&run.property, &run.whole, &environment.file, machines);
            files.push((path.clone(), format!("{trace:#}\n")));
        }
        if let Some(path) = &self.trace {
            match trace(specification, &run.own) {
                Ok(trace) => files.push((path.clone(), trace)),
                Err((report, sources)) => {
                    terminal.report(&report, &sources);
                    return Exit::Findings;
                }
            }
        }
        run_files::save(&files, terminal)
    }
}

/// The inputs of a step.
struct GivenInputs(Vec<(FunctionId, Vec<Value>, Value)>);

impl Environment for GivenInputs {
    fn read(&mut self, function: FunctionId, arguments: &[Value]) -> Result<Option<Value>, String> {
        let known = self.0.iter();
        let mut known = known.filter(|(known, at, _)| *known == function && **at == *arguments);
        Ok(known.next().map(|(_, _, value)| value.clone()))
    }
}

/// The choices of a step, in order.
struct GivenChoices(std::vec::IntoIter<usize>);

impl Chooser for GivenChoices {
    fn choose(&mut self, _count: usize) -> usize {
        self.0.next().unwrap_or(0)
    }
}

/// Executes the specification with the inputs and choices of a run, and returns its trace.
fn trace(specification: Specification, run: &Run) -> Result<String, (Report, Sources)> {
    let mut session = match Session::new(specification) {
        Ok(session) => session,
        Err(failure) => return Err((failure.report, failure.sources)),
    };
    let mut trace = Trace::begin(
        &session.machine,
        "a run that `asmotion verify` found in a composite",
    );
    for step in &run.steps {
        let mut given = GivenInputs(Vec::new());
        for (location, value) in &step.inputs {
            let text = format!("{location} := {value}");
            match session.assignment(&text, &mut asmotion_lang::NoInputs, 0) {
                Ok(assigned) => given.0.push(assigned),
                Err(report) => return Err((report, session.specification.sources)),
            }
        }
        let choices: Vec<usize> = step.choices.iter().map(|it| it.index).collect();
        let mut choices = GivenChoices(choices.into_iter());
        if let Err(fault) = session.machine.step(&mut given, &mut choices, 0) {
            trace.fault(&session.machine, &fault);
            return Ok(trace.end(&session.machine, Some(&fault)));
        }
        trace.step(&session.machine);
    }
    Ok(trace.end(&session.machine, None))
}
