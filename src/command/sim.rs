//! `asmotion sim`: specifications alone.

mod folder;
mod single;

use super::tool::Tool;
use crate::exit::Exit;
use crate::files::Disk;
use crate::terminal::Terminal;
use asmotion_lang::simulate::{Causes, Clock, Random, Recording, Script, Simulation};
use asmotion_lang::{Diagnostic, Failure, Fault, Loader, Options, Report, Specification};
use clap::Args;
use std::path::Path;

/// Runs a specification alone, with scripted, recorded or random inputs.
#[derive(Args)]
pub struct Sim {
    /// The specification; of a folder, every specification in it.
    spec: String,

    /// How many steps; as many as the script or the recording has, or 20 without one.
    #[arg(long)]
    steps: Option<u64>,

    /// Inputs by name, step by step (TOML: `[default]` and `[[step]]` tables); random ones without.
    #[arg(long, value_name = "FILE")]
    env: Option<String>,

    /// Inputs, choices and times of a trace; of a folder, the trace of the same name for each.
    #[arg(long, value_name = "TRACE", conflicts_with = "env")]
    replay_inputs: Option<String>,

    /// Writes down what was read, chosen and written, one fact a line; for a folder, into a folder.
    #[arg(long, value_name = "FILE")]
    trace: Option<String>,

    /// Begins in the initial state of this name instead of the default one.
    #[arg(long, value_name = "NAME")]
    init: Option<String>,

    /// Where it observably differs from the textbook, does what these tools do.
    #[arg(long, value_enum, value_name = "TOOLS")]
    compat: Option<Tool>,

    /// What time it is: `virtual` stands still, `wall` passes, `stepped` or `stepped:ns|us|ms|s|min|h`
    /// passes by one unit a step.
    #[arg(long, value_name = "CLOCK", default_value = "virtual", value_parser = ticking)]
    clock: Ticking,

    /// Decides random inputs and `choose`.
    #[arg(long, default_value_t = 1)]
    seed: u64,

    /// One JSON object a line: each step, then the final state.
    #[arg(long)]
    json: bool,

    /// The final state alone; of a folder, the summary alone.
    #[arg(long, short)]
    quiet: bool,
}

/// What time it is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Ticking {
    Virtual,
    Wall,
    Stepped(i64),
}

fn ticking(text: &str) -> Result<Ticking, String> {
    const SECOND: i64 = 1_000_000_000;
    Ok(match text {
        "virtual" => Ticking::Virtual,
        "wall" => Ticking::Wall,
        "stepped" | "stepped:s" => Ticking::Stepped(SECOND),
        "stepped:ns" => Ticking::Stepped(1),
        "stepped:us" => Ticking::Stepped(1_000),
        "stepped:ms" => Ticking::Stepped(1_000_000),
        "stepped:min" => Ticking::Stepped(60 * SECOND),
        "stepped:h" => Ticking::Stepped(3600 * SECOND),
        _ => {
            let known = "`virtual`, `wall`, `stepped`, `stepped:ns`, `stepped:us`, `stepped:ms`, `stepped:s`, `stepped:min`, `stepped:h`";
            return Err(format!("the clocks are {known}"));
        }
    })
}

impl Ticking {
    fn clock(self) -> Clock {
        match self {
            Self::Virtual => Clock::Virtual,
            Self::Stepped(unit) => Clock::Stepped(unit),
            Self::Wall => {
                let begin = std::time::Instant::now();
                Clock::Told(Box::new(move || {
                    i64::try_from(begin.elapsed().as_nanos()).unwrap_or(i64::MAX)
                }))
            }
        }
    }
}

/// How many steps a run takes whose inputs have no end.
const STEPS: u64 = 20;

/// No initial state has the name that was asked for.
const NO_SUCH_STATE: &str = "A027";

/// Why a run does not begin.
enum Unbegun {
    /// The inputs cannot be read.
    Inputs(Report),
    /// There is no initial state.
    Fault(Box<Fault>),
}

impl Sim {
    /// Runs it.
    pub fn run(self, terminal: &mut Terminal) -> Exit {
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

    /// A run of an opened specification; inputs recorded in this file, if in one.
    fn begin(
        &self,
        specification: &mut Specification,
        recorded: Option<&str>,
    ) -> Result<Simulation, Unbegun> {
        let machine = specification.machine().map_err(Unbegun::Fault)?;
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

    fn open(&self, path: &str) -> Result<Specification, Failure> {
        let options = Options {
            compatible: self.compat.is_some(),
            initial: self.init.clone(),
        };
        asmotion_lang::open_with(path, &Disk, &options)
    }

    /// A specification with errors; an initial state that it does not have was named wrongly.
    fn refused(&self, failure: &Failure) -> Exit {
        let mut codes = failure
            .report
            .diagnostics
            .iter()
            .map(|finding| finding.code);
        match self.init.is_some() && codes.any(|code| code == NO_SUCH_STATE) {
            true => Exit::Usage,
            false => Exit::refused(&self.spec),
        }
    }

    fn steps(&self, simulation: &Simulation) -> u64 {
        self.steps.or(simulation.steps()).unwrap_or(STEPS)
    }
}

fn script(path: &str, specification: &mut Specification) -> Result<Script, Unbegun> {
    let text = read(path, "--env")?;
    let file = specification.sources.add(path, text.clone());
    Script::read(file, &text, &specification.program).map_err(Unbegun::Inputs)
}

/// The text of a file that an option names.
fn read(path: &str, option: &str) -> Result<std::sync::Arc<str>, Unbegun> {
    Disk.read(path).map_err(|error| {
        let mut report = Report::new();
        let help = format!("check the path given with `{option}`");
        report.push(Diagnostic::error("S000", error).help(help));
        Unbegun::Inputs(report)
    })
}

/// What a trace says about where it comes from.
fn comment(path: &str) -> String {
    format!("asm {path}")
}
