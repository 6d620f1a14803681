//! Systems of machines and their environment, from the options of the command.

use super::Verify;
use crate::codes::s000::UnreadableScript;
use crate::exit::Exit;
use crate::paths::FileKind;
use crate::terminal::{TerminalOutput, count};
use asmotion_diagnostics::Finding;
use asmotion_lang::simulate::Script;
use asmotion_lang::{Loader, ReadOptions, Report, Specification};
use asmotion_verify::{
    EnvironmentModel, MachineSchedule, MessageModel, SystemSpecification, VerifiedMachine,
};
use clap::{Args, ValueEnum};
use std::path::Path;

/// Several machines, their messages and their environment.
#[derive(Args)]
pub struct SystemOptions {
    /// Verifies the specifications together: as machines that read each other's functions and exchange messages. `NAME=FILE` gives a
    /// machine another name than its specification
    #[arg(long)]
    pub together: bool,

    /// Machines that make a step at a time
    #[arg(long, value_enum, default_value_t = ScheduleOption::Interleaved, requires = "together")]
    pub schedule: ScheduleOption,

    /// Where inputs come from: `free` (any value in each step), `hold` or `hold=N` (they keep their values; of those that the last
    /// step read, one or N change), a script (`.env.toml`), or a specification that plays the environment
    #[arg(long, value_name = "free|hold|FILE", default_value = "free")]
    pub environment: String,

    /// How messages travel: they arrive before the next step of their receiver, or can be lost, or can arrive later
    #[arg(
        long,
        value_enum,
        value_delimiter = ',',
        value_name = "KINDS",
        default_value = "reliable"
    )]
    pub messages: Vec<DeliveryOption>,

    /// Number of messages that can wait for a machine
    #[arg(long, value_name = "N", default_value_t = 4)]
    pub mailbox: usize,
}

/// Machines that make a step at a time.
#[derive(Clone, Copy, ValueEnum)]
pub enum ScheduleOption {
    /// One after the other, in every order
    Interleaved,
    /// All at the same time
    Synchronous,
}

/// How messages travel.
#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum DeliveryOption {
    /// Messages arrive before the next step of their receiver
    Reliable,
    /// Messages can be lost
    Lossy,
    /// Messages can arrive any number of steps later, in order
    Delayed,
}

impl SystemOptions {
    pub fn message_model(&self) -> MessageModel {
        MessageModel {
            is_lossy: self.messages.contains(&DeliveryOption::Lossy),
            is_delayed: self.messages.contains(&DeliveryOption::Delayed),
            mailbox: self.mailbox,
        }
    }
}

impl Verify {
    /// Opens a specification. `Err` if it has errors, with the exit code.
    pub(super) fn open(
        &self,
        path: &str,
        initial: Option<String>,
        terminal: &mut TerminalOutput,
    ) -> Result<Specification, Exit> {
        let options = ReadOptions {
            initial,
            ..ReadOptions::default()
        };
        asmotion_lang::open_with(path, &self.files, &options).map_err(|failure| {
            terminal.report(&failure.report, &failure.sources);
            terminal.error(count(&failure.report).unwrap_or_default());
            Exit::refused(path)
        })
    }

    /// Opens the machines of a system, from `FILE` or `NAME=FILE`.
    pub(super) fn machines(
        &self,
        terminal: &mut TerminalOutput,
    ) -> Result<SystemSpecification, Exit> {
        let mut system = SystemSpecification {
            schedule: match self.system.schedule {
                ScheduleOption::Interleaved => MachineSchedule::Interleaved,
                ScheduleOption::Synchronous => MachineSchedule::Synchronous,
            },
            ..SystemSpecification::default()
        };
        for path in &self.paths {
            let text = path.display().to_string();
            let (name, file) = match text.split_once('=') {
                Some((name, file)) => (Some(name.to_owned()), file.to_owned()),
                None => (None, text),
            };
            if FileKind::of(Path::new(&file)) != Some(FileKind::Specification) {
                terminal.error(format_args!("`{file}` is no specification (`.asm`)"));
                return Err(Exit::Usage);
            }
            let specification =
                self.open(&file, self.initial_of(name.as_deref(), &file), terminal)?;
            if specification.model.main.is_none() {
                terminal.error(format_args!("`{file}` is a module without a main rule"));
                return Err(Exit::Usage);
            }
            let mut machine = VerifiedMachine::of(specification);
            machine.name = name.unwrap_or(machine.name);
            if system.machines.iter().any(|it| it.name == machine.name) {
                terminal.error(format_args!(
                    "two machines are called `{}`: name one with `NAME=FILE`",
                    machine.name
                ));
                return Err(Exit::Usage);
            }
            system.machines.push(machine);
        }
        system.environment = self.environment(&mut system.machines, terminal)?;
        Ok(system)
    }

    /// The initial state of a machine, from `--init MACHINE=NAME`.
    fn initial_of(&self, name: Option<&str>, file: &str) -> Option<String> {
        let (machine, initial) = self.init.as_deref()?.split_once('=')?;
        let stem = Path::new(file).file_stem()?.to_str();
        (Some(machine) == name.or(stem)).then(|| initial.to_owned())
    }

    /// Reads the environment of a system.
    pub(super) fn environment(
        &self,
        machines: &mut [VerifiedMachine],
        terminal: &mut TerminalOutput,
    ) -> Result<EnvironmentModel, Exit> {
        let text = self.system.environment.as_str();
        let changes = match text {
            "free" => return Ok(EnvironmentModel::Free),
            "hold" => Some(Ok(1)),
            _ => text.strip_prefix("hold=").map(str::parse::<u32>),
        };
        match (changes, FileKind::of(Path::new(text)), machines) {
            (Some(Ok(changes)), ..) => Ok(EnvironmentModel::Hold { changes }),
            (None, Some(FileKind::Specification), _) => {
                let specification = self.open(text, None, terminal)?;
                Ok(EnvironmentModel::Specification(Box::new(specification)))
            }
            (None, Some(FileKind::Script), [machine]) => self
                .script(text, &mut machine.specification, terminal)
                .map(EnvironmentModel::Script),
            (None, Some(FileKind::Script), _) => {
                terminal.error("a script has the inputs of one specification: use a specification as the environment of several");
                Err(Exit::Usage)
            }
            (Some(Err(_)), ..) | (None, ..) => {
                terminal.error(format_args!(
                    "`--environment {text}` is neither `free`, `hold`, `hold=N`, a script (`.env.toml`) nor a specification (`.asm`)"
                ));
                Err(Exit::Usage)
            }
        }
    }

    /// Reads a script.
    fn script(
        &self,
        path: &str,
        specification: &mut Specification,
        terminal: &mut TerminalOutput,
    ) -> Result<Script, Exit> {
        let text = match self.files.read(path) {
            Ok(text) => text,
            Err(error) => {
                let mut report = Report::new();
                let named = "the path given with `--environment`".to_owned();
                report.push(UnreadableScript { error, named }.diagnostic());
                terminal.report(&report, &specification.sources);
                return Err(Exit::Usage);
            }
        };
        let file = specification.sources.add(path, text.clone());
        let script = match Script::read(file, &text, &specification.program) {
            Ok(script) => script,
            Err(report) => {
                terminal.report(&report, &specification.sources);
                terminal.error(count(&report).unwrap_or_default());
                return Err(Exit::Findings);
            }
        };
        Ok(script)
    }
}
