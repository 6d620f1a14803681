//! `asmotion sim`: simulates specifications.

mod several;
mod single;

use super::tool::Tool;
use crate::codes::s000::UnreadableScript;
use crate::exit::Exit;
use crate::files::DiskLoader;
use crate::paths::{FileKind, named_files, other_than_specification};
use crate::terminal::TerminalOutput;
use crate::trace::{RecordedRun, RecordedUpdates, ReplayError, is_run_trace, recorded_run};
use asmotion_diagnostics::Finding;
use asmotion_lang::hir::NO_SUCH_INIT;
use asmotion_lang::ir::message_uses;
use asmotion_lang::simulate::{Causes, Random, Recording, Script, Simulation, SimulationClock};
use asmotion_lang::{Loader, OpenFailure, ReadOptions, Report, Specification, StepFault};
use clap::Args;
use std::path::PathBuf;

/// Simulates a specification with scripted, recorded or random inputs.
#[derive(Args)]
pub struct Sim {
    /// Specifications, and folders to simulate all their specifications; `-` is standard input
    #[arg(value_name = "PATH", required = true)]
    paths: Vec<PathBuf>,

    /// Number of steps [default: the length of the script or recording, else 20]
    #[arg(long)]
    steps: Option<u64>,

    /// Script with the inputs of each step (TOML with `[default]` and `[[step]]` tables) [default: random inputs]
    #[arg(long, value_name = "FILE")]
    env: Option<String>,

    /// Trace whose inputs, choices and times are replayed, written by `sim` or by `run`; for several specifications, a folder
    /// with a trace for each
    #[arg(long, value_name = "TRACE", conflicts_with = "env")]
    replay_inputs: Option<String>,

    /// Component whose steps are replayed, if the trace of a run contains several coordinators
    #[arg(long, value_name = "NAME", requires = "replay_inputs")]
    component: Option<String>,

    /// Writes inputs, choices and updates to a file, one per line; for several specifications, into a folder
    #[arg(long, value_name = "FILE")]
    trace: Option<String>,

    /// Name of the initial state [default: the default one]
    #[arg(long, value_name = "NAME")]
    init: Option<String>,

    /// Follows this tool where it observably differs from the textbook
    #[arg(long, value_enum, value_name = "TOOLS")]
    compat: Option<Tool>,

    /// Clock of the time functions: `virtual` stands still, `wall` is the system clock, `stepped` or
    /// `stepped:ns|us|ms|s|min|h` advances by one unit each step
    #[arg(long, value_name = "CLOCK", default_value = "virtual", value_parser = ticking)]
    clock: SimClock,

    /// Seed for random inputs and `choose`
    #[arg(long, default_value_t = 1)]
    seed: u64,

    /// Prints JSON, one object per line: each step, then the final state
    #[arg(long)]
    json: bool,

    /// Prints only the final state; for several specifications, only the summary
    #[arg(long, short)]
    quiet: bool,
}

/// Clock of the time functions.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum SimClock {
    Virtual,
    Wall,
    Stepped(i64),
}

fn ticking(text: &str) -> Result<SimClock, String> {
    const SECOND: i64 = 1_000_000_000;
    Ok(match text {
        "virtual" => SimClock::Virtual,
        "wall" => SimClock::Wall,
        "stepped" | "stepped:s" => SimClock::Stepped(SECOND),
        "stepped:ns" => SimClock::Stepped(1),
        "stepped:us" => SimClock::Stepped(1_000),
        "stepped:ms" => SimClock::Stepped(1_000_000),
        "stepped:min" => SimClock::Stepped(60 * SECOND),
        "stepped:h" => SimClock::Stepped(3600 * SECOND),
        _ => {
            let accepted = "`virtual`, `wall`, `stepped`, `stepped:ns`, `stepped:us`, `stepped:ms`, `stepped:s`, `stepped:min`, `stepped:h`";
            return Err(format!("the clocks are {accepted}"));
        }
    })
}

impl SimClock {
    fn clock(self) -> SimulationClock {
        match self {
            Self::Virtual => SimulationClock::Virtual,
            Self::Stepped(unit) => SimulationClock::Stepped(unit),
            Self::Wall => {
                let begin = std::time::Instant::now();
                SimulationClock::Told(Box::new(move || {
                    i64::try_from(begin.elapsed().as_nanos()).unwrap_or(i64::MAX)
                }))
            }
        }
    }
}

/// Number of steps if the inputs have no end.
const STEPS: u64 = 20;

/// Reasons why a run cannot start.
enum SimStartError {
    /// The inputs cannot be read.
    Inputs(Report),
    /// The trace cannot be replayed.
    Replay(Box<ReplayError>),
    /// The initial state cannot be computed.
    Fault(Box<StepFault>),
}

/// A simulation and, if it replays the trace of a run, the updates of its steps.
struct StartedSimulation {
    simulation: Simulation,
    expected: Vec<RecordedUpdates>,
}

impl Sim {
    pub fn run(self, terminal: &mut TerminalOutput) -> Exit {
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
        match files.as_slice() {
            [file] if file.folder.is_none() => self.single(&file.text(), terminal),
            several => self.several(several, terminal),
        }
    }

    /// Starts a run of an opened specification, with recorded inputs if `recorded` is given.
    fn start(
        &self,
        specification: &mut Specification,
        recorded: Option<&str>,
    ) -> Result<StartedSimulation, SimStartError> {
        let mut expected = Vec::new();
        let machine = specification.machine().map_err(SimStartError::Fault)?;
        let causes = match (&self.env, recorded) {
            (Some(path), _) => Causes::Script(script(path, specification)?),
            (None, Some(path)) => {
                let run = self.recorded(path, specification)?;
                expected = run.steps;
                Causes::Recording(Recording::read(&run.causes))
            }
            (None, None) => {
                let program = specification.program.clone();
                Causes::Random(Box::new(Random::new(program, &machine, self.seed)))
            }
        };
        let simulation = Simulation::new(machine, causes, self.seed).timed(self.clock.clock());
        Ok(StartedSimulation {
            simulation,
            expected,
        })
    }

    /// Reads the trace to replay, of a simulation or of a run.
    fn recorded(
        &self,
        path: &str,
        specification: &Specification,
    ) -> Result<RecordedRun, SimStartError> {
        let refused = |error| SimStartError::Replay(Box::new(error));
        let text = read(path, "--replay-inputs")?;
        if is_run_trace(&text) {
            let run = recorded_run(path, &text, self.component.as_deref()).map_err(refused)?;
            return if message_uses(&specification.model).is_empty() {
                Ok(run)
            } else {
                let specification = specification.model.name.to_string();
                Err(refused(ReplayError::Messages { specification }))
            };
        }
        let path = path.to_owned();
        if self.component.is_some() {
            return Err(refused(ReplayError::NoComponents { path }));
        }
        if Recording::read(&text).steps().is_empty() {
            return Err(refused(ReplayError::Empty { path }));
        }
        Ok(RecordedRun {
            causes: text.to_string(),
            steps: Vec::new(),
        })
    }

    fn open(&self, path: &str) -> Result<Specification, OpenFailure> {
        let options = ReadOptions {
            compatible: self.compat.is_some(),
            initial: self.init.clone(),
        };
        asmotion_lang::open_with(path, &DiskLoader, &options)
    }

    /// Exit code for a specification with errors; an unknown initial state is a usage error.
    fn refused(&self, path: &str, failure: &OpenFailure) -> Exit {
        let mut findings = failure.report.diagnostics.iter();
        if self.init.is_some() && findings.any(|finding| finding.is_any(&[NO_SUCH_INIT])) {
            Exit::Usage
        } else {
            Exit::refused(path)
        }
    }

    fn steps(&self, simulation: &Simulation) -> u64 {
        self.steps.or(simulation.steps()).unwrap_or(STEPS)
    }
}

fn script(path: &str, specification: &mut Specification) -> Result<Script, SimStartError> {
    let text = read(path, "--env")?;
    let file = specification.sources.add(path, text.clone());
    Script::read(file, &text, &specification.program).map_err(SimStartError::Inputs)
}

/// Reads a file named by an option.
fn read(path: &str, option: &str) -> Result<std::sync::Arc<str>, SimStartError> {
    DiskLoader.read(path).map_err(|error| {
        let mut report = Report::new();
        let named = format!("the path given with `{option}`");
        report.push(UnreadableScript { error, named }.diagnostic());
        SimStartError::Inputs(report)
    })
}

/// The comment in a trace that names its specification.
fn comment(path: &str) -> String {
    format!("asm {path}")
}
