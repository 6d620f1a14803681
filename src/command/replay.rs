//! `asmotion replay`: repeats the steps of recorded coordinators, and compares them with the recording.

mod console;
mod export;
mod json;
mod junit;
mod outcome;
mod session;
mod stop;
mod words;

use std::path::PathBuf;
use std::rc::Rc;
use std::time::Instant;

use asmotion_lang::OpenFailure;
use asmotion_recording::{EditedSpecification, RunFiles};
use clap::Args;

use self::export::ExportFormat;
use self::outcome::{RecordingOutcome, ReplayVerdict};
use self::session::ReplaySession;
use self::stop::StopPoint;
use crate::build::Build;
use crate::exit::Exit;
use crate::files::{DiskLoader, reason};
use crate::terminal::{TerminalOutput, count};

/// Repeats the steps of recorded coordinators, and compares them with the recording.
///
/// A recording is a file of `asmotion run --record FILE.mcap` or of `[deploy] record`. Every step is made again from its record: on
/// the recorded inputs, choices, messages and time. The exit code is 0 if all steps are equal, 1 if one is different, and 2 if a
/// recording cannot be replayed, for example because it has no step.
#[derive(Args)]
pub struct Replay {
    /// Recordings, and folders with some; a recording in several files is named by its first one
    #[arg(value_name = "PATH", required = true)]
    paths: Vec<PathBuf>,

    /// Specification to run in the place of the recorded one, in the coordinators whose specification has its name
    #[arg(long, value_name = "FILE")]
    spec: Option<String>,

    /// Coordinator to replay [default: all; with `--spec`, those whose specification has its name]
    #[arg(long, value_name = "NAME")]
    component: Option<String>,

    /// Stops after a step, as in `213`, or at a time of the run, as in `12.5s`, and prints the state there
    #[arg(long, value_name = "STEP|TIME", value_parser = StopPoint::parse, conflicts_with = "spec")]
    until: Option<StopPoint>,

    /// Explains the last write to a location, as in `mode` or `doing(ROB1)`: the rule, its guards with their values, the cause
    #[arg(long, value_name = "LOCATION", conflicts_with = "spec")]
    explain: Option<String>,

    /// Writes the steps in another form, up to `--until` or the end
    #[arg(long, value_enum, value_name = "FORMAT", conflicts_with_all = ["spec", "explain", "json", "junit"])]
    export: Option<ExportFormat>,

    /// File for the export [default: standard output]
    #[arg(long, short, value_name = "FILE", requires = "export")]
    output: Option<PathBuf>,

    /// Prints JSON, one object per line: each coordinator, then the result
    #[arg(long)]
    json: bool,

    /// Writes a JUnit report with a case for each coordinator
    #[arg(long, value_name = "FILE")]
    junit: Option<PathBuf>,
}

impl Replay {
    /// Replays the recordings and prints the results.
    pub fn run(self, _: &Build, terminal: &mut TerminalOutput) -> Exit {
        let edited = match self.edited(terminal) {
            Ok(edited) => edited,
            Err(exit) => return exit,
        };
        let paths = match recordings(&self.paths) {
            Ok(paths) => paths,
            Err(error) => {
                terminal.error(error);
                return Exit::Usage;
            }
        };
        let began = Instant::now();
        let groups = RunFiles::group(&paths);
        if groups.len() > 1
            && (self.until.is_some() || self.explain.is_some() || self.export.is_some())
        {
            terminal.error(format_args!(
                "`--until`, `--explain` and `--export` need one recording, and there are {}",
                groups.len()
            ));
            return Exit::Usage;
        }
        let replayed = groups.into_iter().map(|files| match files {
            Ok(files) => self.replay(&files, edited.as_ref()),
            Err((path, error)) => RecordingOutcome::refused(path, error),
        });
        let mut outcomes: Vec<_> = replayed.collect();
        outcome::accept_processes_without_coordinator(&mut outcomes);
        self.finish(&outcomes, began, terminal)
    }

    /// Opens the edited specification.
    fn edited(
        &self,
        terminal: &mut TerminalOutput,
    ) -> Result<Option<Rc<EditedSpecification>>, Exit> {
        let Some(path) = &self.spec else {
            return Ok(None);
        };
        match asmotion_lang::open(path, &DiskLoader) {
            Ok(opened) => Ok(Some(Rc::new(EditedSpecification::of(&opened)))),
            Err(OpenFailure { report, sources }) => {
                terminal.report(&report, &sources);
                terminal.error(count(&report).unwrap_or_default());
                Err(Exit::refused(path))
            }
        }
    }

    fn replay(
        &self,
        files: &RunFiles,
        edited: Option<&Rc<EditedSpecification>>,
    ) -> RecordingOutcome {
        let session = ReplaySession {
            component: self.component.as_deref(),
            edited,
            until: self.until,
            explained: self.explain.as_deref(),
            export: self.export,
            output: self.output.as_deref(),
        };
        session.replay(files)
    }

    /// Prints the results. Returns the exit code.
    fn finish(
        &self,
        outcomes: &[RecordingOutcome],
        began: Instant,
        terminal: &mut TerminalOutput,
    ) -> Exit {
        let wall = began.elapsed();
        let verdict = outcomes.iter().map(RecordingOutcome::verdict).max();
        let exit = verdict.map_or(Exit::Usage, ReplayVerdict::exit);
        let exit = exit.max(self.export(outcomes, terminal));
        if self.json {
            json::print(outcomes, wall, terminal);
        } else if self.export.is_some() {
            console::print_trouble(outcomes, terminal);
        } else {
            console::print(outcomes, wall, terminal);
        }
        match &self.junit {
            Some(file) => exit.max(junit::write(file, outcomes, terminal)),
            None => exit,
        }
    }

    /// Writes the export of the only coordinator.
    fn export(&self, outcomes: &[RecordingOutcome], terminal: &mut TerminalOutput) -> Exit {
        let exports = outcomes.iter().flat_map(|it| &it.coordinators);
        let exports: Vec<_> = exports.filter_map(|(_, one)| one.export.as_ref()).collect();
        let [export] = exports.as_slice() else {
            return Exit::Ok;
        };
        match export {
            Ok(exported) => {
                for warning in &exported.warnings {
                    terminal.warn(warning);
                }
                self.write(&exported.text, terminal)
            }
            Err(error) => {
                terminal.error(error);
                Exit::Usage
            }
        }
    }

    fn write(&self, text: &str, terminal: &mut TerminalOutput) -> Exit {
        let Some(path) = &self.output else {
            terminal.result(text.trim_end_matches('\n'));
            return Exit::Ok;
        };
        match std::fs::write(path, text) {
            Ok(()) => {
                terminal.status("Exported", path.display());
                Exit::Ok
            }
            Err(error) => {
                terminal.error(format_args!("cannot write `{}`: {error}", path.display()));
                Exit::Usage
            }
        }
    }
}

/// The files named on the command line, and those of folders.
///
/// # Errors
/// A folder cannot be read, or contains no recording.
fn recordings(paths: &[PathBuf]) -> Result<Vec<PathBuf>, String> {
    let mut files = Vec::new();
    for path in paths {
        if !path.is_dir() {
            files.push(path.clone());
            continue;
        }
        let failed = |error| format!("cannot read `{}`: {}", path.display(), reason(&error));
        let mut found = Vec::new();
        for entry in std::fs::read_dir(path).map_err(failed)? {
            let file = entry.map_err(failed)?.path();
            if file
                .extension()
                .is_some_and(|extension| extension == "mcap")
            {
                found.push(file);
            }
        }
        if found.is_empty() {
            return Err(format!(
                "`{}` contains no recording (`.mcap`)",
                path.display()
            ));
        }
        found.sort();
        files.extend(found);
    }
    Ok(files)
}
