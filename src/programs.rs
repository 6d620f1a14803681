//! Programs that implement components, asked for their declarations.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Mutex, PoisonError};

use asmotion_composite::model::Process;
use asmotion_composite::{ProgramAnswer, Programs};
use asmotion_plan::{Implementation, Plan};
use asmotion_program::{ProgramCommand, ProgramError, ask};

/// Answers by command line and directory.
type Answers = BTreeMap<(Vec<String>, PathBuf), ProgramAnswer>;

/// Starts each program once to ask it, for all composites that a build opens.
#[derive(Debug, Default)]
pub struct AskedPrograms {
    answers: Mutex<Answers>,
    is_off: AtomicBool,
}

impl AskedPrograms {
    /// Starts no program from now on.
    pub fn turn_off(&self) {
        self.is_off.store(true, Ordering::Relaxed);
    }
}

impl Programs for AskedPrograms {
    fn ask(&self, command: &ProgramCommand, component: &str) -> Option<ProgramAnswer> {
        if self.is_off.load(Ordering::Relaxed) {
            return None;
        }
        // held while the program answers, so that other threads do not start it again
        let mut answers = self.answers.lock().unwrap_or_else(PoisonError::into_inner);
        let key = (command.words.clone(), command.directory.clone());
        let answer = answers
            .entry(key)
            .or_insert_with(|| ask(command, component));
        Some(answer.clone())
    }
}

/// The processes of a composite that run here.
#[derive(Clone, Debug)]
pub enum ProcessChoice {
    /// All: the whole composite runs in one process.
    All,
    /// The process of this name.
    Named(String),
    /// Those of this machine, and those without a `host`.
    OnHost(String),
}

impl ProcessChoice {
    /// The processes that run on this machine.
    pub fn on_this_machine() -> Self {
        Self::OnHost(this_machine())
    }

    /// The process of this name, or all without one.
    pub fn named(process: Option<&str>) -> Self {
        process.map_or(Self::All, |name| Self::Named(name.to_owned()))
    }

    fn includes(&self, name: &str, host: Option<&str>) -> bool {
        match self {
            Self::All => true,
            Self::Named(chosen) => chosen == name,
            Self::OnHost(here) => host.is_none_or(|host| host == here),
        }
    }
}

/// Name of this machine.
pub fn this_machine() -> String {
    let system = rustix::system::uname();
    system.nodename().to_string_lossy().into_owned()
}

/// Programs, of which those of some processes run here. The others are asked, too, because their types are needed, but may be
/// absent.
pub struct ProgramsHere<'p> {
    pub programs: &'p dyn Programs,
    pub choice: ProcessChoice,
}

impl Programs for ProgramsHere<'_> {
    fn ask(&self, command: &ProgramCommand, component: &str) -> Option<ProgramAnswer> {
        self.programs.ask(command, component)
    }

    fn ask_robot(&self, address: &str, broker: Option<&str>) -> Option<ProgramAnswer> {
        self.programs.ask_robot(address, broker)
    }

    fn runs(&self, process: &Process) -> bool {
        let host = process.host.as_ref().map(|it| it.value.as_str());
        self.choice.includes(&process.name.value, host)
    }
}

/// The programs and components of other robots of a running system. No others are started for a composite that is received over a bus: who may publish
/// there could run any command.
pub struct RunningPrograms<'p>(pub &'p Plan);

impl Programs for RunningPrograms<'_> {
    fn ask(&self, command: &ProgramCommand, _: &str) -> Option<ProgramAnswer> {
        let is_it = |implementation: &Implementation| {
            if let Implementation::Process {
                command: words,
                directory,
                ..
            } = implementation
            {
                let directory = Path::new(directory.as_deref().unwrap_or_default());
                *words == command.words && command.directory == directory
            } else {
                false
            }
        };
        let mut components = self.0.components.iter();
        let running = components.find(|it| is_it(&it.implementation));
        let declaration = running.and_then(|it| it.program.clone());
        Some(declaration.ok_or_else(|| {
            ProgramError::NotStarted {
                command: command.line(),
                reason:
                    "it is no program of the running system; a new one needs a start of the system"
                        .to_owned(),
            }
        }))
    }

    fn ask_robot(&self, address: &str, _: Option<&str>) -> Option<ProgramAnswer> {
        let mut components = self.0.components.iter();
        let running = components.find(|it| it.implementation.robot_component() == Some(address));
        let declaration = running.and_then(|it| it.program.clone());
        Some(declaration.ok_or_else(|| {
            ProgramError::Fault {
            code: String::new(),
            text: "it is no component of the running system; a new one needs a start of the system"
                .to_owned(),
        }
        }))
    }
}
