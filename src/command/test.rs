//! `asmotion test`: runs scenarios and missions.

mod coverage;
mod difference;
mod find;
mod junit;
pub(super) mod mission;
mod report;
mod result;
mod review;
pub(super) mod snapshot;

use self::result::{TestEnd, TestResult};
use super::tool::Tool;
use crate::build::Build;
use crate::exit::Exit;
use crate::files::DiskLoader;
use crate::terminal::TerminalOutput;
use asmotion_lang::coverage::Coverage;
use asmotion_lang::scenario::{ScenarioResult, ScenarioSettings};
use asmotion_lang::simulate::scenario::ScenarioOptions;
use asmotion_lang::{OpenFailure, hir};
use clap::Args;
use rayon::prelude::*;
use std::path::PathBuf;
use std::time::Instant;

/// Runs scenarios and missions: single files, those of a specification or composite, or all of a folder.
///
/// An `.avalla` scenario loads its specification, and passes if all its checks and invariants hold. A
/// snapshot scenario is an input script `spec.name.env.toml` beside `spec.asm`: it passes if the run
/// equals the accepted snapshot `spec.name.snap`. A mission `name.mission.toml` runs a composite in virtual
/// time, with actions and faults, and passes if all its expectations hold. The exit code is 0 if all pass, 1 if some fail, and
/// 2 if some cannot be run.
#[derive(Args)]
pub struct Test {
    /// Scenarios, missions, specifications and composites that have some beside them, and folders; `-` reads a scenario from
    /// standard input
    #[arg(value_name = "PATH", default_value = ".")]
    paths: Vec<PathBuf>,

    /// Runs only scenarios whose path contains this text
    #[arg(long, value_name = "TEXT")]
    filter: Option<String>,

    /// Seed for choices without a `pick`
    #[arg(long, default_value_t = 1)]
    seed: u64,

    /// Maximum number of steps of a `step until`
    #[arg(long, default_value_t = ScenarioOptions::default().max_steps, value_name = "STEPS")]
    max_steps: u64,

    /// Follows another tool: AsmetaV evaluates checks after the `set`s of the next step
    #[arg(long, value_enum)]
    compat: Option<Tool>,

    /// Prints JSON, one object for each scenario
    #[arg(long)]
    json: bool,

    /// Writes the snapshots of all snapshot scenarios that differ
    #[arg(long, conflicts_with = "review")]
    accept: bool,

    /// Asks for each snapshot scenario that differs whether to accept it
    #[arg(long)]
    review: bool,

    /// Shows coverage of the specifications: a table, or the sources with counts in the margin
    #[arg(long, value_enum, num_args = 0..=1, require_equals = true, default_missing_value = "table")]
    coverage: Option<coverage::CoverageFormat>,

    /// Writes coverage as LCOV
    #[arg(long, value_name = "FILE")]
    coverage_out: Option<PathBuf>,

    /// Writes a JUnit report
    #[arg(long, value_name = "FILE")]
    junit: Option<PathBuf>,
}

impl Test {
    /// Runs the scenarios and prints their results.
    pub fn run(self, build: &Build, terminal: &mut TerminalOutput) -> Exit {
        let scenarios = match find::scenarios(&self.paths) {
            Ok(scenarios) => scenarios,
            Err(error) => {
                terminal.error(error);
                return Exit::Usage;
            }
        };
        let selected: Vec<PathBuf> = scenarios
            .into_iter()
            .filter(|path| self.matches_filter(&path.to_string_lossy()))
            .collect();
        if selected.is_empty() {
            terminal.error("no scenario found");
            return Exit::Usage;
        }
        if review::is_automatic() && (self.accept || self.review) {
            terminal.error("`--accept` is disabled where `CI` is set");
            return Exit::Usage;
        }
        let started = Instant::now();
        let mut results: Vec<TestResult> = selected
            .into_par_iter()
            .map(|path| self.run_one(build, path))
            .collect();
        let took = started.elapsed();
        let mut exit = match (self.accept, self.review) {
            (true, _) => review::accept(&mut results, terminal),
            (_, true) => review::review(&mut results, terminal),
            (false, false) => Exit::Ok,
        };
        for one in &results {
            report::print_result(one, self.json, terminal);
        }
        report::print_summary(&results, took, terminal);
        exit = results
            .iter()
            .map(|result| result.end.exit())
            .fold(exit, Exit::max);
        if let Some(file) = &self.junit {
            exit = exit.max(junit::write(file, &results, terminal));
        }
        exit.max(self.print_coverage(&mut results, terminal))
    }

    /// Prints and writes coverage if requested.
    fn print_coverage(&self, results: &mut [TestResult], terminal: &mut TerminalOutput) -> Exit {
        let mut all = Coverage::default();
        for result in results {
            all.add(result.coverage.take().unwrap_or_default());
        }
        if let Some(format) = self.coverage {
            coverage::print(&all, format, terminal);
        }
        let Some(file) = &self.coverage_out else {
            return Exit::Ok;
        };
        match std::fs::write(file, coverage::lcov(&all)) {
            Ok(()) => Exit::Ok,
            Err(error) => {
                terminal.error(format_args!("cannot write `{}`: {error}", file.display()));
                Exit::Usage
            }
        }
    }

    fn matches_filter(&self, path: &str) -> bool {
        self.filter.as_ref().is_none_or(|text| path.contains(text))
    }

    fn run_one(&self, build: &Build, path: PathBuf) -> TestResult {
        if mission::is_mission(&path) {
            mission::run(build, path, self.seed)
        } else if snapshot::is_script(&path) {
            snapshot::run(path, self.seed, self.measures_coverage())
        } else {
            self.scenario(path)
        }
    }

    fn scenario(&self, path: PathBuf) -> TestResult {
        let started = Instant::now();
        let tested =
            asmotion_lang::scenario::test(&path.to_string_lossy(), &DiskLoader, &self.settings());
        let mut result = TestResult::unusable(path);
        match tested {
            Ok(ScenarioResult {
                name,
                outcome,
                report,
                specification,
                coverage,
            }) => {
                result.name = name;
                result.end = TestEnd::Ran(outcome.verdict);
                (result.steps, result.checks) = (outcome.steps, outcome.checks);
                (result.report, result.sources) = (report, specification.sources);
                result.coverage = coverage;
            }
            Err(OpenFailure { sources, report }) => {
                (result.report, result.sources) = (report, sources)
            }
        }
        result.duration = started.elapsed();
        result
    }

    /// Returns `true` if coverage is requested.
    fn measures_coverage(&self) -> bool {
        self.coverage.is_some() || self.coverage_out.is_some()
    }

    fn settings(&self) -> ScenarioSettings {
        ScenarioSettings {
            reading: hir::ReadOptions {
                compatible: self.compat.is_some(),
                initial: None,
            },
            options: ScenarioOptions {
                seed: self.seed,
                max_steps: self.max_steps,
                ..ScenarioOptions::default()
            },
            covers: self.measures_coverage(),
        }
    }
}
