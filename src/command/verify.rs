//! `asmotion verify`: proves properties of specifications for all inputs and choices.

mod export;
mod input_values;
mod json;
mod options;
mod progress;
mod run;
mod show;
mod system;
mod words;

use crate::exit::Exit;
use crate::paths::{FileKind, named_files, other_than_specification};
use crate::terminal::{TerminalOutput, count};
use asmotion_verify::{Progress, SystemSpecification, Verdict, Verification, verify_system};
use clap::Args;
use std::path::PathBuf;
use std::time::{Duration, Instant};
use system::SystemOptions;

/// Verifies properties of specifications for all inputs and choices.
#[derive(Args)]
pub struct Verify {
    /// Specifications, and folders to verify all their specifications
    #[arg(value_name = "PATH", required = true)]
    paths: Vec<PathBuf>,

    /// Checks only this property: a declared name, or a term (an invariant, or a formula of CTL or LTL)
    #[arg(long, value_name = "NAME|TERM")]
    property: Vec<String>,

    /// Looks for a run to a state in which this term is true
    #[arg(long, value_name = "TERM")]
    possible: Vec<String>,

    /// Considers only states and inputs in which this term is true
    #[arg(long, value_name = "TERM")]
    assume: Vec<String>,

    /// A state in which nothing can change any more is not stuck if this term is true in it
    #[arg(long, value_name = "TERM")]
    end: Option<String>,

    /// Values of an input, instead of all those of its domain, as in `distance=0,9,10`
    #[arg(long, value_name = "FUNCTION=VALUE,…")]
    values: Vec<String>,

    /// Considers only runs that are weakly fair to this rule, or to each element of this domain, besides those of `//@Fair`: if
    /// it can move from some point on in every state, it moves again and again
    #[arg(long, value_name = "RULE|DOMAIN")]
    fair: Vec<String>,

    /// Considers only runs that are strongly fair to this rule, or to each element of this domain, besides those of
    /// `//@StronglyFair`: if it can move again and again, it does
    #[arg(long, value_name = "RULE|DOMAIN")]
    strongly_fair: Vec<String>,

    /// Initial state to start from [default: the default one]
    #[arg(long, value_name = "NAME")]
    init: Option<String>,

    /// Explores only states within this number of steps
    #[arg(long, value_name = "STEPS")]
    bound: Option<u32>,

    /// Number of elements that `extend` may create; states with more are not explored
    #[arg(long, value_name = "N", default_value_t = 8)]
    reserve: usize,

    /// Ends the exploration after this number of states
    #[arg(long, value_name = "N")]
    states: Option<u64>,

    /// Ends the exploration when states and transitions occupy this memory
    #[arg(long, value_name = "MIB", default_value_t = 4096)]
    memory: u64,

    /// Ends the exploration after this time
    #[arg(long, value_name = "SECONDS")]
    time: Option<f64>,

    /// Writes the run that shows the first violation to a file, which `asmotion sim --replay-inputs` repeats
    #[arg(long, value_name = "FILE")]
    trace: Option<PathBuf>,

    #[command(flatten)]
    system: SystemOptions,

    /// Prints a JSON object for each specification
    #[arg(long)]
    json: bool,
}

/// Time between two lines of progress.
const PROGRESS: Duration = Duration::from_secs(2);

impl Verify {
    pub fn run(self, terminal: &mut TerminalOutput) -> Exit {
        if self.system.together {
            let exit = self.together(terminal);
            return exit.unwrap_or_else(|exit| exit);
        }
        let files = match named_files(&self.paths, &[FileKind::Specification]) {
            Ok(files) => files,
            Err(error) => {
                terminal.error(error);
                return Exit::Usage;
            }
        };
        if let Some(error) = other_than_specification(&files) {
            terminal.error(error);
            return Exit::Usage;
        }
        if self.trace.is_some() && files.len() > 1 {
            terminal.error("`--trace` is for one specification");
            return Exit::Usage;
        }
        let exits = files.iter().map(|file| self.file(&file.text(), terminal));
        exits.fold(Exit::Ok, Exit::max)
    }

    /// Verifies the specification at a path.
    fn file(&self, path: &str, terminal: &mut TerminalOutput) -> Exit {
        let specification = match self.open(path, self.init.clone(), terminal) {
            Ok(specification) => specification,
            Err(exit) => return exit,
        };
        if specification.model.main.is_none() {
            terminal.status(
                "Skipping",
                format_args!("{path}, a module without a main rule"),
            );
            return Exit::Ok;
        }
        let mut system = SystemSpecification::of(specification);
        match self.environment(&mut system.machines, terminal) {
            Ok(environment) => system.environment = environment,
            Err(exit) => return exit,
        }
        self.verified(path, system, terminal)
            .unwrap_or_else(|exit| exit)
    }

    /// Verifies the specifications as machines of one system.
    fn together(&self, terminal: &mut TerminalOutput) -> Result<Exit, Exit> {
        if self.init.as_ref().is_some_and(|init| !init.contains('=')) {
            terminal.error("several specifications: write `--init MACHINE=NAME`");
            return Err(Exit::Usage);
        }
        let system = self.machines(terminal)?;
        let paths = self.paths.iter().map(|path| path.display().to_string());
        let paths: Vec<String> = paths.collect();
        self.verified(&paths.join(" "), system, terminal)
    }

    /// Verifies a system and shows the result.
    fn verified(
        &self,
        path: &str,
        mut system: SystemSpecification,
        terminal: &mut TerminalOutput,
    ) -> Result<Exit, Exit> {
        let options = self.options(&mut system.machines, terminal)?;
        let begun = Instant::now();
        let mut shown = begun;
        let mut proceed = |progress: Progress| {
            let now = Instant::now();
            if now - shown > PROGRESS {
                shown = now;
                terminal.progress(progress::line(&progress, now - begun));
            }
            let limit = self.time;
            limit.is_none_or(|limit| (now - begun).as_secs_f64() < limit)
        };
        match verify_system(system, &options, &mut proceed) {
            Ok(verification) => {
                if self.json {
                    terminal.result(json::verification(path, &verification, begun.elapsed()));
                } else {
                    show::text(path, &verification, begun.elapsed(), terminal);
                }
                Ok(exit(&verification).max(self.write(&verification, terminal)))
            }
            Err(refusal) => {
                terminal.report(&refusal.report, &refusal.specification.sources);
                terminal.error(count(&refusal.report).unwrap_or_default());
                Err(Exit::Findings)
            }
        }
    }
}

/// The exit code of a verification: a violation counts more than a property that is not known.
fn exit(verification: &Verification) -> Exit {
    let properties = &verification.properties;
    if properties.iter().any(|it| it.verdict.is_violated()) {
        Exit::Findings
    } else if properties
        .iter()
        .any(|it| matches!(it.verdict, Verdict::Unknown))
    {
        Exit::Undecided
    } else {
        Exit::Ok
    }
}
