//! Simulates several specifications and prints a line for each.

use super::{Sim, SimStartError, comment};
use crate::exit::Exit;
use crate::numbers::counted;
use crate::paths::NamedFile;
use crate::terminal::{BAD, FAINT, GOOD, NOTE, TerminalOutput};
use asmotion_lang::simulate::{SimulationError, Trace};
use asmotion_lang::{Diagnostic, OpenFailure, Severity, Specification, StepFault};
use rayon::prelude::*;
use serde_json::json;
use std::fmt;
use std::path::{Component, Path, PathBuf};

/// Result for one specification.
enum SpecificationOutcome {
    /// Ran for this many steps.
    Ran(u64),
    /// A module, which has no main rule.
    Module,
    /// Has errors; the first one, on one line.
    Rejected(String),
    /// A step failed (0 is the initial state): code and message.
    Fault(u64, String),
    /// The specification or its inputs cannot be read, or the trace cannot be written.
    Unusable(String),
}

impl Sim {
    /// Simulates several specifications, and prints a line for each.
    pub(super) fn several(&self, files: &[NamedFile], terminal: &mut TerminalOutput) -> Exit {
        if self.env.is_some() {
            terminal.error("`--env` names inputs, so it needs a single specification");
            return Exit::Usage;
        }
        let outcomes: Vec<SpecificationOutcome> = files
            .par_iter()
            .map(|file| self.outcome(&file.path, &self.name(file)))
            .collect();
        let mut tally = SimSummary::default();
        for (file, outcome) in files.iter().zip(&outcomes) {
            tally.count(outcome);
            if !self.quiet {
                let name = self.name(file).display().to_string();
                self.print_outcome(&name, outcome, terminal);
            }
        }
        terminal.status("Simulated", &tally);
        tally.exit()
    }

    /// The name of a specification, also of its trace: relative to the folder if that is the only argument.
    fn name(&self, file: &NamedFile) -> PathBuf {
        let path = match (&file.folder, self.paths.as_slice()) {
            (Some(folder), [_]) => file.path.strip_prefix(folder).unwrap_or(&file.path),
            (Some(_) | None, _) => &file.path,
        };
        // inside the folder of the traces
        let inside = |part: &Component<'_>| matches!(part, Component::Normal(_));
        path.components().filter(inside).collect()
    }

    /// Opens, checks and runs one specification.
    fn outcome(&self, file: &Path, name: &Path) -> SpecificationOutcome {
        let mut specification = match self.open(&file.to_string_lossy()) {
            Ok(specification) => specification,
            Err(failure) if Exit::refused(file) == Exit::Usage => {
                return SpecificationOutcome::Unusable(first_error(&failure));
            }
            Err(failure) => return rejected(&failure),
        };
        if specification.program.main.is_none() {
            return SpecificationOutcome::Module;
        }
        let matching = |other: &String| Path::new(other).join(name).with_extension("trace");
        let recorded = self.replay_inputs.as_ref().map(matching);
        // a specification without a recording gets random inputs
        let recorded = recorded.filter(|path| path.is_file());
        let recorded = recorded.map(|path| path.to_string_lossy().into_owned());
        let (outcome, trace) = self.traced(&mut specification, recorded.as_deref(), name);
        match (self.trace.as_ref().map(matching), trace) {
            (Some(path), Some(trace)) => match write(&path, &trace) {
                Ok(()) => outcome,
                Err(error) => {
                    SpecificationOutcome::Unusable(format!("{}: {error}", path.display()))
                }
            },
            _ => outcome,
        }
    }

    fn traced(
        &self,
        specification: &mut Specification,
        recorded: Option<&str>,
        name: &Path,
    ) -> (SpecificationOutcome, Option<String>) {
        let comment = comment(&name.to_string_lossy());
        let mut simulation = match self.start(specification, recorded) {
            Ok(started) if self.trace.is_some() => started.simulation.traced(&comment),
            Ok(started) => started.simulation,
            Err(SimStartError::Replay(error)) => {
                return (SpecificationOutcome::Unusable(error.to_string()), None);
            }
            Err(SimStartError::Fault(fault)) => {
                let trace = Trace::failed_initial_state(&specification.program, &fault, &comment);
                return (failed(specification, &fault), Some(trace));
            }
            Err(SimStartError::Inputs(report)) => {
                let reason = report.diagnostics.first();
                let reason = reason.map(|finding| finding.message.clone());
                return (
                    SpecificationOutcome::Unusable(reason.unwrap_or_default()),
                    None,
                );
            }
        };
        let steps = self.steps(&simulation);
        let stopped = (0..steps).find_map(|_| simulation.step().err());
        let (outcome, fault) = match stopped {
            None => (SpecificationOutcome::Ran(steps), None),
            Some(SimulationError::Fault(fault)) => {
                let finding = specification.explain_in(&fault, simulation.machine());
                (
                    SpecificationOutcome::Fault(fault.step, first_line(&finding)),
                    Some(fault),
                )
            }
            Some(reason @ SimulationError::Unreadable { .. }) => {
                (SpecificationOutcome::Unusable(reason.to_string()), None)
            }
        };
        (outcome, simulation.into_trace(fault.as_deref()))
    }

    fn print_outcome(
        &self,
        name: &str,
        outcome: &SpecificationOutcome,
        terminal: &mut TerminalOutput,
    ) {
        let (word, steps, what) = match outcome {
            SpecificationOutcome::Ran(steps) => ("ok", *steps, String::new()),
            SpecificationOutcome::Module => ("module", 0, String::new()),
            SpecificationOutcome::Rejected(first) => ("rejected", 0, first.clone()),
            SpecificationOutcome::Fault(step, what) => ("fault", *step, what.clone()),
            SpecificationOutcome::Unusable(what) => ("unusable", 0, what.clone()),
        };
        if self.json {
            return terminal.result(json!({
                "type": "run", "v": 1, "path": name, "outcome": word, "steps": steps, "what": what,
            }));
        }
        let colour = match outcome {
            SpecificationOutcome::Ran(_) => GOOD,
            SpecificationOutcome::Module => FAINT,
            SpecificationOutcome::Fault(..) => NOTE,
            SpecificationOutcome::Rejected(..) | SpecificationOutcome::Unusable(_) => BAD,
        };
        let what = if what.is_empty() {
            what
        } else {
            format!(": {what}")
        };
        terminal.result(format_args!("{colour}{word:>8}{colour:#} {name}{what}"));
    }
}

fn rejected(failure: &OpenFailure) -> SpecificationOutcome {
    SpecificationOutcome::Rejected(first_error(failure))
}

/// The first error of a specification on one line.
fn first_error(failure: &OpenFailure) -> String {
    let mut findings = failure.report.diagnostics.iter();
    let first = findings.find(|finding| finding.severity == Severity::Error);
    first.map(first_line).unwrap_or_default()
}

fn failed(specification: &Specification, fault: &StepFault) -> SpecificationOutcome {
    SpecificationOutcome::Fault(fault.step, first_line(&specification.explain(fault)))
}

/// The message of a finding on one line; it can quote an invariant with line breaks.
fn first_line(finding: &Diagnostic) -> String {
    let words: Vec<&str> = finding.message.split_whitespace().collect();
    format!("{} {}", finding.code, words.join(" "))
}

fn write(path: &Path, text: &str) -> std::io::Result<()> {
    if let Some(folder) = path.parent() {
        std::fs::create_dir_all(folder)?;
    }
    std::fs::write(path, text)
}

/// Numbers of specifications by result.
#[derive(Default)]
struct SimSummary {
    ran: usize,
    steps: u64,
    modules: usize,
    rejected: usize,
    faults: usize,
    unusable: usize,
}

impl SimSummary {
    fn count(&mut self, outcome: &SpecificationOutcome) {
        match outcome {
            SpecificationOutcome::Ran(steps) => {
                self.ran += 1;
                self.steps += steps;
            }
            SpecificationOutcome::Module => self.modules += 1,
            SpecificationOutcome::Rejected(..) => self.rejected += 1,
            SpecificationOutcome::Fault(steps, _) => {
                self.faults += 1;
                self.steps += steps;
            }
            SpecificationOutcome::Unusable(_) => self.unusable += 1,
        }
    }

    fn exit(&self) -> Exit {
        match (self.unusable, self.faults, self.rejected) {
            (1.., ..) => Exit::Usage,
            (0, 1.., _) => Exit::Fault,
            (0, 0, 1..) => Exit::Findings,
            (0, 0, 0) => Exit::Ok,
        }
    }
}

impl fmt::Display for SimSummary {
    fn fmt(&self, to: &mut fmt::Formatter<'_>) -> fmt::Result {
        let files = self.ran + self.modules + self.rejected + self.faults + self.unusable;
        write!(
            to,
            "{}, {}: {} ran, {} stopped by a fault, {} rejected, {}",
            counted(files as u64, "specification"),
            counted(self.steps, "step"),
            self.ran,
            self.faults,
            self.rejected,
            counted(self.modules as u64, "module"),
        )?;
        match self.unusable {
            0 => Ok(()),
            unusable => write!(to, ", {unusable} that could not be run"),
        }
    }
}
