//! Programs that implement components, asked for their declarations.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Mutex, PoisonError};

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

/// The programs of a running system. No others are started for a composite that is received over a bus: who may publish
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
}
