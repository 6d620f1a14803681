//! `asmotion sim`: specifications alone.

mod folder;
mod single;

use crate::exit::Exit;
use crate::files::Disk;
use crate::terminal::Terminal;
use asm_lang::simulate::{Causes, Random, Recording, Script, Simulation};
use asm_lang::{Diagnostic, Fault, Loader, Report, Specification};
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

/// How many steps a run takes whose inputs have no end.
const STEPS: u64 = 20;

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
        Ok(Simulation::new(machine, causes, self.seed))
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
