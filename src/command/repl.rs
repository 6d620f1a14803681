//! `asmotion repl`: interactive simulation of a specification.

#[cfg(feature = "mcap")]
mod recorded;
mod save;
mod session;
mod verb;

use crate::exit::Exit;
use crate::files::DiskLoader;
use crate::prompt::{Prompt, PromptLine};
use crate::terminal::{TerminalOutput, count};
use crate::trace::{is_run_trace, recorded_run};
use asmotion_lang::simulate::Recording;
use asmotion_lang::{History, Loader, OpenFailure, Session};
use clap::Args;
use session::ReplSession;
use verb::VERBS;

/// Steps a specification interactively: sets inputs, evaluates terms, undoes steps, finds the writer of a location.
#[derive(Args)]
pub struct Repl {
    /// Specification file [default: the one in the recording]
    #[arg(required_unless_present = "from")]
    spec: Option<String>,

    /// Starts with the steps of a recording (`run --record FILE.mcap`), or of a trace of `asmotion verify`, `asmotion sim` or
    /// `asmotion run`: `step` repeats the next one, `undo` goes back
    #[arg(long, value_name = "FILE")]
    from: Option<String>,

    /// Coordinator whose steps are repeated, if a recording has several
    #[arg(long, value_name = "NAME", requires = "from")]
    component: Option<String>,

    /// Machine whose steps are repeated, from 1, if the coordinator began again during the run
    #[arg(long, value_name = "NUMBER", requires = "from", default_value_t = 1)]
    machine: usize,

    /// Uses random values for inputs that are not set; without this option they are undef
    #[arg(long)]
    random: bool,

    /// Seed for `choose`, and for inputs with `--random`
    #[arg(long, default_value_t = 1)]
    seed: u64,
}

impl Repl {
    /// Reads and executes commands until the end of input.
    pub fn run(self, terminal: &mut TerminalOutput) -> Exit {
        let ReplStart {
            path,
            session,
            recording,
        } = match self.start(terminal) {
            Ok(start) => start,
            Err(exit) => return exit,
        };
        let mut prompt = match Prompt::new(VERBS, "_$", "repl_history") {
            Ok(prompt) => prompt,
            Err(error) => {
                terminal.error(format_args!("cannot read the input: {error}"));
                return Exit::Usage;
            }
        };
        prompt.set_names(names(&session));
        let history = History::of_recording(session, self.seed, self.random, recording);
        let mut talk = ReplSession::new(path, self.seed, history);
        talk.print_banner(terminal);
        loop {
            match prompt.read(&talk.prompt()) {
                PromptLine::Text(line) => {
                    if !talk.execute(&line, terminal) {
                        break;
                    }
                }
                PromptLine::Nothing => {}
                PromptLine::End => break,
            }
        }
        prompt.save_history();
        Exit::Ok
    }

    /// Opens the specification, and the recording or trace.
    fn start(&self, terminal: &mut TerminalOutput) -> Result<ReplStart, Exit> {
        #[cfg(feature = "mcap")]
        if let Some(files) = self.from.as_deref().and_then(recorded::files) {
            return self.of_recording(&files, terminal);
        }
        let usage = |error: String, terminal: &mut TerminalOutput| {
            terminal.error(error);
            Exit::Usage
        };
        let recording = match &self.from {
            None => Recording::default(),
            Some(path) => recording(path).map_err(|error| usage(error, terminal))?,
        };
        let Some(path) = self.spec.clone() else {
            let from = self.from.as_deref().unwrap_or_default();
            let error = format!(
                "`{from}` is a trace: name its specification, as in `asmotion repl SPEC --from {from}`"
            );
            return Err(usage(error, terminal));
        };
        if self.component.is_some() || self.machine != 1 {
            let error = "`--component` and `--machine` select from a recording (`.mcap`)";
            return Err(usage(error.to_owned(), terminal));
        }
        let session = asmotion_lang::open(&path, &DiskLoader).and_then(Session::new);
        let session = session.map_err(|failure| refused(failure, &path, terminal))?;
        Ok(ReplStart {
            path,
            session,
            recording,
        })
    }
}

/// The beginning of a session.
struct ReplStart {
    /// Path of the specification.
    path: String,
    session: Session,
    /// The steps that are repeated; none without a recording.
    recording: Recording,
}

/// Prints why a specification cannot be opened.
fn refused(failure: OpenFailure, path: &str, terminal: &mut TerminalOutput) -> Exit {
    let OpenFailure { report, sources } = failure;
    terminal.report(&report, &sources);
    terminal.error(count(&report).unwrap_or_default());
    Exit::refused(path)
}

/// Reads the steps of a trace.
///
/// # Errors
/// The file cannot be read, or it contains no steps.
fn recording(path: &str) -> Result<Recording, String> {
    let text = DiskLoader.read(path).map_err(|error| error.to_string())?;
    let text = if is_run_trace(&text) {
        let run = recorded_run(path, &text, None).map_err(|error| error.to_string())?;
        run.causes
    } else {
        text.to_string()
    };
    let recording = Recording::read(&text);
    if recording.steps().is_empty() {
        return Err(format!("`{path}` contains no steps"));
    }
    Ok(recording)
}

/// The names in a specification, for completion.
fn names(session: &Session) -> Vec<String> {
    let model = &session.specification.model;
    let functions = model
        .own_functions()
        .map(|(_, function)| function.name.to_string());
    let rules = model.rules.iter().filter(|rule| !rule.library);
    let atoms = model.atoms.iter().map(|atom| atom.name.to_string());
    let rules = rules.map(|rule| rule.name.to_string());
    functions.chain(rules).chain(atoms).collect()
}
