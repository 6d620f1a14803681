//! Snapshot scenarios: a run with scripted inputs, held against what it wrote when it was accepted.
//!
//! `patrol.corridor.env.toml` runs `patrol.asm`, which stands beside it, for as many steps as the
//! script has; what the run reads, writes and prints stands in `patrol.corridor.snap`.

use super::{End, Ended};
use crate::diff::unified;
use crate::files::Disk;
use asm_lang::machine::Machine;
use asm_lang::simulate::scenario::Verdict;
use asm_lang::simulate::{self, Causes, Script, Simulation, Stopped};
use asm_lang::{Diagnostic, Loader, Report, Sources, Specification};
use std::fmt::Write;
use std::path::{Path, PathBuf};
use std::time::Instant;

/// What the names of the scripts end with.
const SCRIPT: &str = ".env.toml";

/// Whether a file is the script of such a scenario.
pub fn is_script(path: &Path) -> bool {
    path.to_string_lossy().ends_with(SCRIPT)
}

/// What a run wrote, and what was accepted.
pub struct Difference {
    /// The file of the snapshot.
    pub path: PathBuf,
    /// What was accepted, if anything was.
    accepted: Option<String>,
    /// What the run wrote.
    actual: String,
}

impl Difference {
    /// From what was accepted to what was written.
    pub fn diff(&self) -> String {
        let accepted = self.accepted.as_deref().unwrap_or("");
        unified(&self.path.to_string_lossy(), accepted, &self.actual)
    }

    /// Accepts what the run wrote.
    pub fn accept(&self) -> std::io::Result<()> {
        std::fs::write(&self.path, &self.actual)
    }
}

/// Runs the scenario of a script.
pub fn run(script: PathBuf, seed: u64) -> Ended {
    let begun = Instant::now();
    let mut ended = Ended::unusable(script.clone());
    match actual(&script, seed) {
        Ok((steps, specification, actual)) => {
            let (verdict, difference) = compare(&script, actual);
            ended.end = End::Ran(verdict);
            ended.steps = steps;
            ended.sources = specification.sources;
            ended.report.extend(difference.iter().map(said).collect());
            ended.difference = difference;
        }
        Err((report, sources)) => (ended.report, ended.sources) = (report, sources),
    }
    ended.took = begun.elapsed();
    ended
}

fn compare(script: &Path, actual: String) -> (Verdict, Option<Difference>) {
    let path = PathBuf::from(script.to_string_lossy().replace(SCRIPT, ".snap"));
    // one that cannot be read is as good as none
    let accepted = std::fs::read_to_string(&path).ok();
    if accepted.as_deref() == Some(&actual) {
        return (Verdict::Pass, None);
    }
    let difference = Difference {
        path,
        accepted,
        actual,
    };
    (Verdict::Fail, Some(difference))
}

fn said(difference: &Difference) -> Diagnostic {
    let path = difference.path.display();
    match difference.accepted {
        None => Diagnostic::error("V030", format!("there is no snapshot `{path}`"))
            .help("read what the run wrote, and accept it with `--accept`"),
        Some(_) => Diagnostic::error("V031", format!("the run differs from `{path}`"))
            .help("accept what is meant with `--accept`, or one by one with `--review`"),
    }
}

/// What the run writes, and after how many steps.
fn actual(script: &Path, seed: u64) -> Result<(u64, Specification, String), (Report, Sources)> {
    let spec = specification(script);
    let mut specification = asm_lang::open(&spec.to_string_lossy(), &Disk)
        .map_err(|failure| (failure.report, failure.sources))?;
    let script = match read(script, &mut specification) {
        Ok(script) => script,
        Err(report) => return Err((report, specification.sources)),
    };
    let mut text = String::new();
    let machine = match specification.machine() {
        Ok(machine) => machine,
        Err(fault) => {
            let finding = specification.explain(&fault);
            line(
                &mut text,
                format_args!("{} {}", finding.code, finding.message),
            );
            return Ok((0, specification, text));
        }
    };
    let steps = script.len() as u64;
    let mut simulation = Simulation::new(machine, Causes::Script(script), seed);
    for _ in 0..steps {
        match simulation.step() {
            Ok(()) => step(&mut text, simulation.machine()),
            Err(Stopped::Fault(fault)) => {
                let finding = specification.explain_in(&fault, simulation.machine());
                line(
                    &mut text,
                    format_args!("{} {}", finding.code, finding.message),
                );
                break;
            }
            Err(stopped @ Stopped::Unreadable { .. }) => {
                line(&mut text, format_args!("{stopped}"));
                break;
            }
        }
    }
    let done = simulation.machine().steps();
    Ok((done, specification, text))
}

/// The specification of a script: what its name begins with.
fn specification(script: &Path) -> PathBuf {
    let name = script.file_name().unwrap_or_default().to_string_lossy();
    let stem = name.split('.').next().unwrap_or_default();
    script.with_file_name(format!("{stem}.asm"))
}

fn read(path: &Path, specification: &mut Specification) -> Result<Script, Report> {
    let path = path.to_string_lossy();
    let text = Disk.read(&path).map_err(|error| {
        let finding = Diagnostic::error("S000", error).help("check the path of the script");
        [finding].into_iter().collect::<Report>()
    })?;
    let file = specification.sources.add(&path, text.clone());
    Script::read(file, &text, &specification.program)
}

fn step(text: &mut String, machine: &Machine) {
    let step = machine.last_step();
    let naming = machine.naming();
    line(text, format_args!("step {}", step.number));
    for input in step.inputs {
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
    for printed in step.printed {
        line(text, format_args!("  print: {printed}"));
    }
}

fn line(text: &mut String, line: std::fmt::Arguments<'_>) {
    // writing to a string cannot fail
    let _ = writeln!(text, "{line}");
}
