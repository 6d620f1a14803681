//! `asmotion test`: scenarios, and what came of them.

mod find;
mod junit;
mod report;

use crate::exit::Exit;
use crate::files::Disk;
use crate::terminal::Terminal;
use asm_lang::scenario::Tested;
use asm_lang::simulate::scenario::{Compat, Options, Verdict};
use asm_lang::{Failure, Report, Sources};
use clap::{Args, ValueEnum};
use rayon::prelude::*;
use std::path::PathBuf;
use std::time::{Duration, Instant};

/// Runs scenarios: `.avalla` files, one by one or all of a folder.
///
/// A folder is searched through. Each scenario loads its specification, and passes if all its checks
/// and invariants hold. The exit code is 0 if all pass, 1 if some fail, and 2 if some cannot be run.
#[derive(Args)]
pub struct Test {
    /// Scenarios and folders.
    #[arg(value_name = "PATH", default_value = ".")]
    paths: Vec<PathBuf>,

    /// Only scenarios whose path contains this text.
    #[arg(long, value_name = "TEXT")]
    filter: Option<String>,

    /// Decides what a scenario does not pick.
    #[arg(long, default_value_t = 1)]
    seed: u64,

    /// `step until` does no more steps than this.
    #[arg(long, default_value_t = Options::default().max_steps, value_name = "STEPS")]
    max_steps: u64,

    /// Reads scenarios as another tool does: AsmetaV checks after all `set`s before the next step.
    #[arg(long, value_enum)]
    compat: Option<Tool>,

    /// One JSON object a scenario.
    #[arg(long)]
    json: bool,

    /// Writes what came of them for a build server.
    #[arg(long, value_name = "FILE")]
    junit: Option<PathBuf>,
}

/// A tool whose reading of scenarios differs.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(super) enum Tool {
    /// AsmetaV
    Asmeta,
}

/// A test, and how it ended.
struct Ended {
    /// Its file, as it was found.
    path: PathBuf,
    /// What it is called.
    name: String,
    end: End,
    steps: u64,
    checks: u64,
    took: Duration,
    /// What there is to say, and the texts it is about.
    report: Report,
    sources: Sources,
}

/// How a test ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum End {
    /// It ran.
    Ran(Verdict),
    /// It cannot be run.
    Unusable,
}

impl End {
    fn word(self) -> &'static str {
        match self {
            Self::Ran(verdict) => verdict.word(),
            Self::Unusable => "unusable",
        }
    }

    fn exit(self) -> Exit {
        match self {
            Self::Ran(Verdict::Pass) => Exit::Ok,
            Self::Ran(Verdict::Fail | Verdict::Invariant | Verdict::Fault) => Exit::Findings,
            Self::Unusable => Exit::Usage,
        }
    }
}

impl Test {
    /// Runs them.
    pub fn run(self, terminal: &mut Terminal) -> Exit {
        let found = match find::scenarios(&self.paths) {
            Ok(found) => found,
            Err(error) => {
                terminal.error(error);
                return Exit::Usage;
            }
        };
        let wanted: Vec<PathBuf> = found
            .into_iter()
            .filter(|path| self.is_wanted(&path.to_string_lossy()))
            .collect();
        if wanted.is_empty() {
            terminal.error("there is no scenario here");
            return Exit::Usage;
        }
        let begun = Instant::now();
        let ended: Vec<Ended> = wanted.into_par_iter().map(|path| self.one(path)).collect();
        for one in &ended {
            report::tell(one, self.json, terminal);
        }
        report::sum_up(&ended, begun.elapsed(), terminal);
        let exit = ended.iter().map(|one| one.end.exit()).max();
        let exit = exit.unwrap_or(Exit::Ok);
        match &self.junit {
            Some(file) => exit.max(junit::write(file, &ended, terminal)),
            None => exit,
        }
    }

    fn is_wanted(&self, path: &str) -> bool {
        self.filter.as_ref().is_none_or(|text| path.contains(text))
    }

    fn one(&self, path: PathBuf) -> Ended {
        let begun = Instant::now();
        let compat = match self.compat {
            Some(Tool::Asmeta) => Compat::Asmeta,
            None => Compat::Textbook,
        };
        let options = Options {
            seed: self.seed,
            max_steps: self.max_steps,
            ..Options::default()
        };
        let tested = asm_lang::scenario::test(&path.to_string_lossy(), &Disk, compat, &options);
        let took = begun.elapsed();
        match tested {
            Ok(Tested {
                name,
                outcome,
                report,
                specification,
            }) => Ended {
                path,
                name,
                end: End::Ran(outcome.verdict),
                steps: outcome.steps,
                checks: outcome.checks,
                took,
                report,
                sources: specification.sources,
            },
            Err(Failure { sources, report }) => Ended {
                name: String::new(),
                path,
                end: End::Unusable,
                steps: 0,
                checks: 0,
                took,
                report,
                sources,
            },
        }
    }
}
