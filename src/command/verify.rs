//! `asmotion verify`: proves properties of specifications for all inputs and choices.

mod avalla;
mod composite;
mod engine;
mod export;
mod follow_up;
mod input_values;
mod interrupt;
mod itf;
mod json;
mod memory;
mod mutants;
mod options;
mod progress;
mod projection;
mod run;
mod run_files;
mod search;
mod show;
mod system;
mod watch;
mod watched_results;
mod words;

use self::progress::ExplorationProgress;
use crate::build::Build;
use crate::exit::Exit;
use crate::files::NotedFiles;
use crate::paths::{FileKind, named_files, other_than_specification};
use crate::terminal::{TerminalOutput, count};
use asmotion_verify::{
    KeptExploration, Progress, SystemSpecification, Verdict, Verification, verify_again,
    verify_system,
};
use clap::Args;
use composite::CompositeOptions;
use engine::EngineOption;
use memory::MemoryLimit;
use search::SearchOptions;
use std::path::PathBuf;
use std::time::Duration;
use system::SystemOptions;
use watched_results::WatchedResults;

/// Verifies properties of specifications for all inputs and choices.
#[derive(Args)]
pub struct Verify {
    /// Specifications, composites (`.composite.toml`), and folders to verify all their specifications
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

    /// Explores states one by one, or sets of them as decision diagrams
    #[arg(long, value_name = "ENGINE", value_enum, default_value_t = EngineOption::Explicit)]
    engine: EngineOption,

    /// Explores only states within this number of steps
    #[arg(long, value_name = "STEPS")]
    bound: Option<u32>,

    /// Number of elements that `extend` may create; states with more are not explored
    #[arg(long, value_name = "N", default_value_t = 8)]
    reserve: usize,

    /// Ends the exploration after this number of states
    #[arg(long, value_name = "N")]
    states: Option<u64>,

    /// Ends the verification when states and transitions occupy this memory [default: half of the memory of the machine]
    #[arg(long, value_name = "MIB")]
    memory: Option<u64>,

    /// Ends the verification after this time
    #[arg(long, value_name = "SECONDS")]
    time: Option<f64>,

    /// Writes the run that shows the first violation to a file, which `asmotion sim --replay-inputs` repeats
    #[arg(long, value_name = "FILE")]
    trace: Option<PathBuf>,

    /// Writes that run as a scenario, which `asmotion test` repeats
    #[arg(long, value_name = "FILE", conflicts_with = "init")]
    avalla: Option<PathBuf>,

    /// Writes that run in the Informal Trace Format (JSON)
    #[arg(long, value_name = "FILE")]
    itf: Option<PathBuf>,

    /// Lists parts that never run, values that never occur, updates that change nothing, and inputs that nothing reads
    #[arg(long)]
    advice: bool,

    /// Changes the specification in one place at a time, and lists the changes that no property notices
    #[arg(long, conflicts_with_all = ["trace", "avalla", "itf", "watch", "advice"])]
    mutants: bool,

    /// Verifies again when a file of the specification or composite changes, and shows which verdicts change
    #[arg(long, conflicts_with = "json")]
    watch: bool,

    #[command(flatten)]
    search: SearchOptions,

    #[command(flatten)]
    system: SystemOptions,

    #[command(flatten)]
    composite: CompositeOptions,

    /// Prints a JSON object for each specification
    #[arg(long)]
    json: bool,

    /// The files that were read
    #[arg(skip)]
    files: NotedFiles,
}

const MUTANTS_OF_ONE: &str = "`--mutants` is for one specification";

impl Verify {
    pub fn run(self, build: &Build, terminal: &mut TerminalOutput) -> Exit {
        interrupt::install();
        if self.system.together {
            if self.mutants {
                terminal.error(MUTANTS_OF_ONE);
                return Exit::Usage;
            }
            let paths = self.paths.iter().map(|path| path.display().to_string());
            let paths = paths.collect::<Vec<String>>().join(" ");
            return self.once_or_watched(&paths, terminal, |watched, terminal| {
                let exit = self.together(&paths, watched, terminal);
                exit.unwrap_or_else(|exit| exit)
            });
        }
        let files = match named_files(&self.paths, &[FileKind::Specification]) {
            Ok(files) => files,
            Err(error) => {
                terminal.error(error);
                return Exit::Usage;
            }
        };
        let (composites, files): (Vec<_>, Vec<_>) = files
            .into_iter()
            .partition(|file| FileKind::of(&file.path) == Some(FileKind::Composite));
        if let Some(error) = self.misplaced(!composites.is_empty(), !files.is_empty()) {
            terminal.error(error);
            return Exit::Usage;
        }
        if let Some(error) = other_than_specification(&files) {
            terminal.error(error);
            return Exit::Usage;
        }
        if self.has_exports() && files.len() + composites.len() > 1 {
            terminal
                .error("`--trace`, `--avalla` and `--itf` are for one specification or composite");
            return Exit::Usage;
        }
        if self.watch && files.len() + composites.len() != 1 {
            terminal.error(
                "`--watch` is for one specification, one composite, or specifications with `--together`",
            );
            return Exit::Usage;
        }
        if self.mutants {
            let ([file], []) = (files.as_slice(), composites.as_slice()) else {
                terminal.error(MUTANTS_OF_ONE);
                return Exit::Usage;
            };
            return self.mutants_of(&file.text(), terminal);
        }
        let mut worst = Exit::Ok;
        for composite in &composites {
            let path = composite.text();
            let verify =
                |watched: &mut _, terminal: &mut _| self.composite(build, &path, watched, terminal);
            worst = worst.max(self.once_or_watched(&path, terminal, verify));
        }
        for file in &files {
            let path = file.text();
            let verify = |watched: &mut _, terminal: &mut _| self.file(&path, watched, terminal);
            worst = worst.max(self.once_or_watched(&path, terminal, verify));
        }
        worst
    }

    /// Verifies once, or again and again with `--watch`.
    fn once_or_watched(
        &self,
        paths: &str,
        terminal: &mut TerminalOutput,
        mut verify: impl FnMut(&mut WatchedResults, &mut TerminalOutput) -> Exit,
    ) -> Exit {
        if self.watch {
            self.watch(paths, terminal, verify)
        } else {
            verify(&mut WatchedResults::none(), terminal)
        }
    }

    /// Verifies the specification at a path.
    fn file(
        &self,
        path: &str,
        watched: &mut WatchedResults,
        terminal: &mut TerminalOutput,
    ) -> Exit {
        match self.file_system(path, terminal) {
            Ok(Some(system)) => self
                .verified(path, system, watched, terminal)
                .unwrap_or_else(|exit| exit),
            Ok(None) => Exit::Ok,
            Err(exit) => exit,
        }
    }

    /// Opens the specification at a path, with its environment; `None` for a module.
    fn file_system(
        &self,
        path: &str,
        terminal: &mut TerminalOutput,
    ) -> Result<Option<SystemSpecification>, Exit> {
        let specification = self.open(path, self.init.clone(), terminal)?;
        if specification.model.main.is_none() {
            terminal.status(
                "Skipping",
                format_args!("{path}, a module without a main rule"),
            );
            return Ok(None);
        }
        let mut system = SystemSpecification::of(specification);
        system.environment = self.environment(&mut system.machines, terminal)?;
        Ok(Some(system))
    }

    /// Verifies the specifications as machines of one system.
    fn together(
        &self,
        paths: &str,
        watched: &mut WatchedResults,
        terminal: &mut TerminalOutput,
    ) -> Result<Exit, Exit> {
        if self.init.as_ref().is_some_and(|init| !init.contains('=')) {
            terminal.error("several specifications: write `--init MACHINE=NAME`");
            return Err(Exit::Usage);
        }
        let system = self.machines(terminal)?;
        self.verified(paths, system, watched, terminal)
    }

    /// Verifies a system and shows the result.
    fn verified(
        &self,
        path: &str,
        system: SystemSpecification,
        watched: &mut WatchedResults,
        terminal: &mut TerminalOutput,
    ) -> Result<Exit, Exit> {
        let (verification, time) =
            self.verification(system, watched.exploration(path), terminal)?;
        let exit = self.present(path, &verification, time, terminal);
        watched.show_changes(path, &verification, terminal);
        Ok(exit)
    }

    /// Verifies a system, and shows the progress and the reasons for which it cannot be verified.
    fn verification(
        &self,
        mut system: SystemSpecification,
        kept: Option<&mut KeptExploration>,
        terminal: &mut TerminalOutput,
    ) -> Result<(Verification, Duration), Exit> {
        let options = self.options(&mut system.machines, terminal)?;
        let mut exploration = ExplorationProgress::new(options.limits.memory.unwrap_or(0));
        let mut proceed = |progress: Progress| {
            exploration.show(&progress, terminal);
            let seconds = exploration.elapsed().as_secs_f64();
            !interrupt::has_occurred() && self.time.is_none_or(|limit| seconds < limit)
        };
        let verified = match kept {
            Some(kept) => verify_again(system, &options, kept, &mut proceed),
            None => verify_system(system, &options, &mut proceed),
        };
        match verified {
            Ok(verification) => Ok((verification, exploration.elapsed())),
            Err(refusal) => {
                terminal.report(&refusal.report, &refusal.specification.sources);
                terminal.error(count(&refusal.report).unwrap_or_default());
                Err(Exit::Findings)
            }
        }
    }

    fn memory_limit(&self) -> MemoryLimit {
        MemoryLimit::of(self.memory)
    }

    /// Shows the result of a verification and writes the files that were requested.
    fn present(
        &self,
        path: &str,
        verification: &Verification,
        time: Duration,
        terminal: &mut TerminalOutput,
    ) -> Exit {
        if self.json {
            terminal.result(json::verification(path, verification, time));
        } else {
            show::text(path, verification, time, self.memory_limit(), terminal);
            if self.symmetry() && verification.symmetric.is_empty() {
                show::without_symmetry(verification, terminal);
            }
            // states that were known before are all those that are needed
            let is_known = verification.is_reused;
            if self.cone() && verification.left_out.is_empty() && !is_known {
                show::without_cone(verification, terminal);
            }
            if self.independent() && !verification.has_left_out_steps {
                show::without_independence(verification, terminal);
            }
            if self.advice {
                show::advice(verification, terminal);
            }
            let shown = run_files::shown(verification).filter(|(it, _)| it.verdict.is_violated());
            if let (Some((property, _)), [_]) = (shown, verification.machines.as_slice()) {
                self.follow_up(path, property, terminal);
            }
        }
        exit(verification).max(self.write(path, verification, terminal))
    }
}

/// The exit code of a verification: a violation counts more than a property that is not known, or not for certain.
fn exit(verification: &Verification) -> Exit {
    let properties = &verification.properties;
    if properties.iter().any(|it| it.verdict.is_violated()) {
        Exit::Findings
    } else if properties
        .iter()
        .any(|it| matches!(it.verdict, Verdict::Unknown) || words::is_qualified(it, verification))
    {
        Exit::Undecided
    } else {
        Exit::Ok
    }
}
