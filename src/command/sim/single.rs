//! Simulates one specification.

use super::{Sim, SimStartError, StartedSimulation, comment};
use crate::exit::Exit;
use crate::show;
use crate::terminal::{FAINT, NAME, TerminalOutput, count};
use crate::trace::{RecordedUpdates, ReplayError};
use asmotion_lang::machine::Machine;
use asmotion_lang::simulate::{self, SimulationError, Trace};
use asmotion_lang::{Diagnostic, Report, Severity, Specification};
use serde_json::{Map, Value, json};

/// Compares the last step with the recorded one.
///
/// # Errors
/// [`ReplayError::Deviates`] if their update sets differ, [`ReplayError::DoesNotFail`] if the recorded step failed.
fn compare(machine: &Machine, recorded: Option<RecordedUpdates>) -> Result<(), Box<ReplayError>> {
    let Some(recorded) = recorded else {
        return Ok(());
    };
    let updates = simulate::updates(machine, &machine.last_step()).into_iter();
    let replayed: Vec<String> = updates
        .map(|(location, _, after)| format!("{location} = {after}"))
        .collect();
    match &recorded.updates {
        Some(updates) if *updates == replayed => Ok(()),
        Some(_) => Err(Box::new(ReplayError::Deviates { recorded, replayed })),
        None => Err(Box::new(ReplayError::DoesNotFail { recorded, replayed })),
    }
}

/// Checks before the simulation that its trace can be written.
fn is_writable(path: &str) -> std::io::Result<()> {
    let mut options = std::fs::OpenOptions::new();
    options.create(true).append(true).open(path).map(drop)
}

fn cannot_write(error: &std::io::Error, trace: Option<&str>) -> String {
    let path = trace.unwrap_or_default();
    format!("cannot write the trace `{path}`: {error}")
}

impl Sim {
    /// Simulates the specification at a path.
    pub(super) fn single(&self, path: &str, terminal: &mut TerminalOutput) -> Exit {
        let mut specification = match self.open(path) {
            Ok(specification) => specification,
            Err(failure) => {
                terminal.report(&failure.report, &failure.sources);
                terminal.error(count(&failure.report).unwrap_or_default());
                return self.refused(path, &failure);
            }
        };
        if let Some(Err(error)) = self.trace.as_deref().map(is_writable) {
            terminal.error(cannot_write(&error, self.trace.as_deref()));
            return Exit::Usage;
        }
        if specification.report.count(Severity::Warning) > 0 {
            terminal.report(&specification.report, &specification.sources);
        }
        let comment = comment(path);
        let recorded = self.replay_inputs.as_deref();
        let StartedSimulation {
            mut simulation,
            expected,
        } = match self.start(&mut specification, recorded) {
            Ok(started) => started,
            Err(SimStartError::Replay(error)) => {
                terminal.error(error);
                return Exit::Usage;
            }
            Err(SimStartError::Inputs(report)) => {
                terminal.report(&report, &specification.sources);
                return Exit::Usage;
            }
            Err(SimStartError::Fault(fault)) => {
                let trace = Trace::failed_initial_state(&specification.program, &fault, &comment);
                let exit = self.fault(specification.explain(&fault), 0, &specification, terminal);
                return exit.max(self.write(Some(trace), terminal));
            }
        };
        let doubts = specification.doubts(simulation.machine());
        if !doubts.diagnostics.is_empty() {
            terminal.report(&doubts, &specification.sources);
        }
        if self.trace.is_some() {
            simulation = simulation.traced(&comment);
        }
        let mut stopped = None;
        let mut expected = expected.into_iter();
        for _ in 0..self.steps(&simulation) {
            if let Err(reason) = simulation.step() {
                stopped = Some(reason);
                break;
            }
            if !self.quiet {
                self.step(simulation.machine(), terminal);
            }
            if let Err(error) = compare(simulation.machine(), expected.next()) {
                terminal.error(error);
                return Exit::Findings;
            }
        }
        if !(self.json && stopped.is_some()) {
            self.state(simulation.machine(), terminal);
        }
        let exit = match &stopped {
            None => Exit::Ok,
            Some(SimulationError::Fault(fault)) => {
                let finding = specification.explain_in(fault, simulation.machine());
                self.fault(finding, fault.step, &specification, terminal)
            }
            Some(SimulationError::Unreadable { .. }) => Exit::Usage,
        };
        let fault = match stopped {
            Some(SimulationError::Fault(fault)) => Some(fault),
            Some(reason @ SimulationError::Unreadable { .. }) => {
                terminal.error(reason);
                None
            }
            None => None,
        };
        let trace = simulation.into_trace(fault.as_deref());
        exit.max(self.write(trace, terminal))
    }

    /// Writes the trace if it was requested.
    fn write(&self, trace: Option<String>, terminal: &mut TerminalOutput) -> Exit {
        let (Some(path), Some(trace)) = (&self.trace, trace) else {
            return Exit::Ok;
        };
        match std::fs::write(path, trace) {
            Ok(()) => Exit::Ok,
            Err(error) => {
                terminal.error(cannot_write(&error, Some(path)));
                Exit::Usage
            }
        }
    }

    fn step(&self, machine: &Machine, terminal: &mut TerminalOutput) {
        let step = machine.last_step();
        if self.json {
            return terminal.result(show::step_json(machine, &step));
        }
        terminal.result(format_args!("{NAME}step {}{NAME:#}", step.number()));
        let naming = machine.naming();
        for input in step.inputs() {
            let location = simulate::location(machine, input.slot);
            terminal.result(format_args!(
                "  {FAINT}{location} = {}{FAINT:#}",
                input.value.show(&naming)
            ));
        }
        for (location, before, after) in simulate::updates(machine, &step) {
            terminal.result(format_args!(
                "  {location} := {after}  {FAINT}(was {before}){FAINT:#}"
            ));
        }
        for sent in step.sent() {
            terminal.result(format_args!("  {}", simulate::sent(machine, sent)));
        }
        for line in step.printed() {
            terminal.result(format_args!("  print: {line}"));
        }
        if step.updates().is_empty() {
            terminal.result(format_args!("  {FAINT}no updates{FAINT:#}"));
        }
    }

    fn state(&self, machine: &Machine, terminal: &mut TerminalOutput) {
        let state = simulate::state(machine);
        if self.json {
            let state: Map<String, Value> = state
                .into_iter()
                .map(|(location, value)| (location, Value::String(value)))
                .collect();
            return terminal.result(
                json!({ "type": "state", "v": 1, "steps": machine.steps(), "state": state }),
            );
        }
        terminal.result(format_args!(
            "{NAME}state after step {}{NAME:#}",
            machine.steps()
        ));
        for (location, value) in state {
            terminal.result(format_args!("  {location} = {value}"));
        }
    }

    fn fault(
        &self,
        finding: Diagnostic,
        step: u64,
        specification: &Specification,
        terminal: &mut TerminalOutput,
    ) -> Exit {
        if self.json {
            terminal.result(json!({
                "type": "fault", "v": 1, "step": step, "code": finding.code.name, "message": finding.message,
            }));
        }
        let mut report = Report::new();
        report.push(finding);
        terminal.report(&report, &specification.sources);
        Exit::Fault
    }
}
