//! Shared test support: files, a catalogue, specifications and rendering.
#![allow(dead_code, reason = "every test binary uses a part of it")]

pub mod catalogue;
pub mod files;
pub mod render;
pub mod specification;
pub mod variables;

use asmotion_composite::model::Process;
use asmotion_composite::{Context, ProgramAnswer, Programs};
use asmotion_plan::Opened;
use asmotion_program::{ProgramCommand, ProgramError};

pub use catalogue::SmallBuild;
pub use files::Files;
pub use variables::Variables;

/// Knows that there is no program `missing`, and asks no other one. Runs on another machine than `robot`.
struct MissingProgram;

impl Programs for MissingProgram {
    fn ask(&self, command: &ProgramCommand, _: &str) -> Option<ProgramAnswer> {
        let command = command.words.first().filter(|word| *word == "missing")?;
        Some(Err(ProgramError::NotStarted {
            command: command.clone(),
            reason: "file not found".to_owned(),
        }))
    }

    fn runs(&self, process: &Process) -> bool {
        process
            .host
            .as_ref()
            .is_none_or(|host| host.value != "robot")
    }
}

/// Opens a composite of a folder with the test context.
pub fn open(folder: &str, file: &str) -> Opened {
    let files = Files::new(folder);
    asmotion_plan::open(file, &context(&files))
}

/// The context used by all tests.
pub fn context(files: &Files) -> Context<'_> {
    Context {
        loader: files,
        environment: &Variables,
        catalogue: &SmallBuild,
        specifications: files,
        programs: &MissingProgram,
        settings: &[],
    }
}
