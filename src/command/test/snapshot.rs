//! Snapshot scenarios: compare a run with scripted inputs with its accepted output.
//!
//! `patrol.corridor.env.toml` runs `patrol.asm` in the same folder for as many steps as the script has; the expected
//! inputs, updates and output are in `patrol.corridor.snap`.

use super::difference::SnapshotDifference;
use super::result::{TestEnd, TestResult};
use crate::codes::s000::UnreadableScript;
use crate::codes::v030::NoSnapshot;
use crate::codes::v031::SnapshotDiffers;
use crate::files::DiskLoader;
use crate::paths::FileKind;
use asmotion_diagnostics::Finding;
use asmotion_lang::coverage::Coverage;
use asmotion_lang::machine::Machine;
use asmotion_lang::simulate::scenario::Verdict;
use asmotion_lang::simulate::{self, Causes, Script, Simulation, SimulationError};
use asmotion_lang::{Diagnostic, Loader, OpenFailure, Report, Specification};
use std::fmt::Write;
use std::path::{Path, PathBuf};
use std::time::Instant;

/// Suffix of scripts.
const SCRIPT: &str = ".env.toml";

/// Returns `true` if the file is the script of a snapshot scenario.
pub fn is_script(path: &Path) -> bool {
    FileKind::of(path) == Some(FileKind::Script)
}

/// Runs the scenario of a script, with coverage if `covers` is set.
pub(super) fn run(path: PathBuf, seed: u64, covers: bool) -> TestResult {
    let started = Instant::now();
    let mut result = TestResult::unusable(path.clone());
    match run_script(&path, seed, covers) {
        Ok(run) => {
            let (verdict, difference) = compare(&path, SCRIPT, run.text);
            result.end = TestEnd::Ran(verdict);
            result.steps = run.steps;
            result.coverage = run.coverage;
            result.sources = run.specification.sources;
            result
                .report
                .extend(difference.iter().map(diagnostic).collect());
            result.difference = difference;
        }
        Err(OpenFailure { report, sources }) => (result.report, result.sources) = (report, sources),
    }
    result.duration = started.elapsed();
    result
}

/// Compares the run of a mission with its snapshot, whose name replaces `suffix` by `.snap`.
pub(super) fn compare_into(result: &mut TestResult, suffix: &str, actual: String) {
    let (verdict, difference) = compare(&result.path, suffix, actual);
    if result.end == TestEnd::Ran(Verdict::Pass) {
        result.end = TestEnd::Ran(verdict);
    }
    let finding = difference.iter().map(diagnostic).collect();
    result.report.extend(finding);
    result.difference = difference;
}

fn compare(script: &Path, suffix: &str, actual: String) -> (Verdict, Option<SnapshotDifference>) {
    let text = script.to_string_lossy();
    let stem = text.strip_suffix(suffix).unwrap_or(&text);
    let path = PathBuf::from(format!("{stem}.snap"));
    // an unreadable snapshot counts as missing
    let accepted = std::fs::read_to_string(&path).ok();
    if accepted.as_deref() == Some(&actual) {
        return (Verdict::Pass, None);
    }
    let difference = SnapshotDifference {
        path,
        accepted,
        actual,
    };
    (Verdict::Fail, Some(difference))
}

fn diagnostic(difference: &SnapshotDifference) -> Diagnostic {
    let path = difference.path.display().to_string();
    match difference.accepted {
        None => NoSnapshot { path }.diagnostic(),
        Some(_) => SnapshotDiffers { path }.diagnostic(),
    }
}

/// Opens the specification of a script and reads the script.
pub fn open(script: &str, loader: &dyn Loader) -> Result<(Specification, Script), OpenFailure> {
    let mut specification = asmotion_lang::open(&specification(Path::new(script)), loader)?;
    match read(script, &mut specification, loader) {
        Ok(script) => Ok((specification, script)),
        Err(report) => {
            let sources = specification.sources;
            Err(OpenFailure { report, sources })
        }
    }
}

/// A completed run.
struct SnapshotRun {
    specification: Specification,
    /// Number of steps.
    steps: u64,
    /// Inputs, updates and output.
    text: String,
    coverage: Option<Coverage>,
}

fn run_script(path: &Path, seed: u64, covers: bool) -> Result<SnapshotRun, OpenFailure> {
    let (mut specification, script) = open(&path.to_string_lossy(), &DiskLoader)?;
    if covers && let Err(report) = specification.lower_covered() {
        let sources = specification.sources;
        return Err(OpenFailure { report, sources });
    }
    let mut text = String::new();
    let (mut steps, mut coverage) = (0, None);
    match specification.machine() {
        Ok(machine) => {
            let max_steps = script.len();
            let simulation = Simulation::new(machine, Causes::Script(script), seed);
            let simulation = run_simulation(simulation, max_steps, &specification, &mut text);
            let machine = simulation.machine();
            steps = machine.steps();
            coverage = covers.then(|| Coverage::of(&specification, &machine.counts()));
        }
        Err(fault) => fault_line(&mut text, &specification.explain(&fault)),
    }
    Ok(SnapshotRun {
        specification,
        steps,
        text,
        coverage,
    })
}

/// Makes up to this number of steps and records each.
fn run_simulation(
    mut simulation: Simulation,
    steps: usize,
    specification: &Specification,
    text: &mut String,
) -> Simulation {
    for _ in 0..steps {
        match simulation.step() {
            Ok(()) => step(text, simulation.machine()),
            Err(SimulationError::Fault(fault)) => {
                let finding = specification.explain_in(&fault, simulation.machine());
                fault_line(text, &finding);
                break;
            }
            Err(stopped @ SimulationError::Unreadable { .. }) => {
                line(text, format_args!("{stopped}"));
                break;
            }
        }
    }
    simulation
}

/// The specification of a script: the part of its name before the first dot.
pub(super) fn specification(script: &Path) -> String {
    let name = script.file_name().unwrap_or_default().to_string_lossy();
    let stem = name.split('.').next().unwrap_or_default();
    let path = script.with_file_name(format!("{stem}.asm"));
    path.to_string_lossy().into_owned()
}

fn read(
    path: &str,
    specification: &mut Specification,
    loader: &dyn Loader,
) -> Result<Script, Report> {
    let text = loader.read(path).map_err(|error| {
        let named = "the path of the script".to_owned();
        let finding = UnreadableScript { error, named };
        [finding.diagnostic()].into_iter().collect::<Report>()
    })?;
    let file = specification.sources.add(path, text.clone());
    Script::read(file, &text, &specification.program)
}

fn fault_line(text: &mut String, finding: &Diagnostic) {
    let Diagnostic { code, message, .. } = finding;
    line(text, format_args!("{code} {message}"));
}

fn step(text: &mut String, machine: &Machine) {
    let step = machine.last_step();
    let naming = machine.naming();
    line(text, format_args!("step {}", step.number()));
    for input in step.inputs() {
        let location = simulate::location(machine, input.slot);
        line(
            text,
            format_args!("  {location} = {}", input.value.show(&naming)),
        );
    }
    for (location, before, after) in simulate::updates(machine, &step) {
        line(
            text,
            format_args!("  {location} := {after}  (was {before})"),
        );
    }
    for sent in step.sent() {
        let sent = simulate::sent(machine, sent);
        line(text, format_args!("  {sent}"));
    }
    for printed in step.printed() {
        line(text, format_args!("  print: {printed}"));
    }
}

fn line(text: &mut String, line: std::fmt::Arguments<'_>) {
    // writing to a string cannot fail
    let _ = writeln!(text, "{line}");
}
