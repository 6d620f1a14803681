//! `asmotion repl`: interactive simulation of a specification.

mod save;
mod session;
mod verb;

use crate::exit::Exit;
use crate::files::DiskLoader;
use crate::prompt::{Prompt, PromptLine};
use crate::terminal::{TerminalOutput, count};
use asmotion_lang::{History, OpenFailure, Session};
use clap::Args;
use session::ReplSession;
use verb::VERBS;

/// Steps a specification interactively: sets inputs, evaluates terms, undoes steps, finds the writer of a location.
#[derive(Args)]
pub struct Repl {
    /// Specification file
    spec: String,

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
        let history = History::new(session, self.seed, self.random);
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
