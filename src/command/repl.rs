//! `asmotion repl`: a specification at a prompt.

mod prompt;
mod save;
mod talk;
mod verb;

use crate::exit::Exit;
use crate::files::Disk;
use crate::terminal::{Terminal, count};
use asm_lang::{Failure, History, Session};
use clap::Args;
use prompt::{Line, Prompt};
use talk::Talk;

/// Steps a specification by hand: sets inputs, asks for values, goes back, says who wrote what.
#[derive(Args)]
pub struct Repl {
    /// The specification.
    spec: String,

    /// Inputs that nobody set are random; they are undef without it.
    #[arg(long)]
    random: bool,

    /// Decides `choose`, and inputs with `--random`.
    #[arg(long, default_value_t = 1)]
    seed: u64,
}

impl Repl {
    /// Talks until the input ends.
    pub fn run(self, terminal: &mut Terminal) -> Exit {
        let session = asm_lang::open(&self.spec, &Disk).and_then(Session::new);
        let session = match session {
            Ok(session) => session,
            Err(Failure { report, sources }) => {
                terminal.report(&report, &sources);
                terminal.error(count(&report).unwrap_or_default());
                return Exit::refused(&self.spec);
            }
        };
        let mut prompt = match Prompt::new(&session) {
            Ok(prompt) => prompt,
            Err(error) => {
                terminal.error(format_args!("cannot read the input: {error}"));
                return Exit::Usage;
            }
        };
        let history = History::new(session, self.seed, self.random);
        let mut talk = Talk::new(self.spec, self.seed, history);
        talk.greet(terminal);
        loop {
            match prompt.read(&talk.prompt()) {
                Line::Text(line) => {
                    if !talk.answer(&line, terminal) {
                        break;
                    }
                }
                Line::Nothing => {}
                Line::End => break,
            }
        }
        prompt.keep();
        Exit::Ok
    }
}
