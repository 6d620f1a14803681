//! `asmotion sim`: simulates specifications.

mod folder;
mod single;

use super::tool::Tool;
use crate::codes::s000::UnreadableScript;
use crate::exit::Exit;
use crate::files::DiskLoader;
use crate::terminal::TerminalOutput;
use asmotion_diagnostics::Finding;
use asmotion_lang::hir::NO_SUCH_INIT;
use asmotion_lang::simulate::{Causes, Random, Recording, Script, Simulation, SimulationClock};
use asmotion_lang::{Loader, OpenFailure, ReadOptions, Report, Specification, StepFault};
use clap::Args;
use std::path::Path;

/// Simulates a specification with scripted, recorded or random inputs.
#[derive(Args)]
pub struct Sim {
    /// Specification, or a folder to simulate all its specifications
    spec: String,

    /// Number of steps [default: the length of the script or recording, else 20]
    #[arg(long)]
    steps: Option<u64>,

    /// Script with the inputs of each step (TOML with `[default]` and `[[step]]` tables) [default: random inputs]
    #[arg(long, value_name = "FILE")]
    env: Option<String>,

    /// Trace whose inputs, choices and times are replayed; for a folder, a folder with a trace for each specification
    #[arg(long, value_name = "TRACE", conflicts_with = "env")]
    replay_inputs: Option<String>,

    /// Writes inputs, choices and updates to a file, one per line; for a folder, into a folder
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

    /// Prints only the final state; for a folder, only the summary
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
    /// The initial state cannot be computed.
    Fault(Box<StepFault>),
}

impl Sim {
    pub fn run(self, terminal: &mut TerminalOutput) -> Exit {
        let path = Path::new(&self.spec);
        if path.is_dir() {
            return self.folder(path, terminal);
        }
        if self.spec.ends_with(".toml") {
            terminal.error(format_args!(
                "`{0}` is a composite: `asmotion run {0}` runs it",
                self.spec
            ));
            return Exit::Usage;
        }
        self.single(terminal)
    }

    /// Starts a run of an opened specification, with recorded inputs if `recorded` is given.
    fn start(
        &self,
        specification: &mut Specification,
        recorded: Option<&str>,
    ) -> Result<Simulation, SimStartError> {
        let machine = specification.machine().map_err(SimStartError::Fault)?;
        let causes = match (&self.env, recorded) {
            (Some(path), _) => Causes::Script(script(path, specification)?),
            (None, Some(path)) => {
                Causes::Recording(Recording::read(&read(path, "--replay-inputs")?))
            }
            (None, None) => {
                let program = specification.program.clone();
                Causes::Random(Box::new(Random::new(program, &machine, self.seed)))
            }
        };
        Ok(Simulation::new(machine, causes, self.seed).timed(self.clock.clock()))
    }

    fn open(&self, path: &str) -> Result<Specification, OpenFailure> {
        let options = ReadOptions {
            compatible: self.compat.is_some(),
            initial: self.init.clone(),
        };
        asmotion_lang::open_with(path, &DiskLoader, &options)
    }

    /// Exit code for a specification with errors; an unknown initial state is a usage error.
    fn refused(&self, failure: &OpenFailure) -> Exit {
        let mut findings = failure.report.diagnostics.iter();
        if self.init.is_some() && findings.any(|finding| finding.is_any(&[NO_SUCH_INIT])) {
            Exit::Usage
        } else {
            Exit::refused(&self.spec)
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
