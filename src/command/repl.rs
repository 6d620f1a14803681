//! `asmotion repl`: interactive simulation of a specification.

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
    /// Specification file
    spec: String,

    /// Starts with the steps of a trace, of `asmotion verify`, `asmotion sim` or `asmotion run`: `step` repeats the next one, `undo`
    /// goes back
    #[arg(long, value_name = "TRACE")]
    from: Option<String>,

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
        let session = asmotion_lang::open(&self.spec, &DiskLoader).and_then(Session::new);
        let session = match session {
            Ok(session) => session,
            Err(OpenFailure { report, sources }) => {
                terminal.report(&report, &sources);
                terminal.error(count(&report).unwrap_or_default());
                return Exit::refused(&self.spec);
            }
        };
        let mut prompt = match Prompt::new(VERBS, "_$", "repl_history") {
            Ok(prompt) => prompt,
            Err(error) => {
                terminal.error(format_args!("cannot read the input: {error}"));
                return Exit::Usage;
            }
        };
        prompt.set_names(names(&session));
        let history = match &self.from {
            None => History::new(session, self.seed, self.random),
            Some(path) => match recording(path) {
                Ok(recording) => History::of_recording(session, self.seed, self.random, recording),
                Err(error) => {
                    terminal.error(error);
                    return Exit::Usage;
                }
            },
        };
        let mut talk = ReplSession::new(self.spec, self.seed, history);
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
