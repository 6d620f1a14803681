//! Lines as the terminal edits them, without completion and memory.

use std::io::{self, BufRead, IsTerminal, Write};

use super::{PromptLine, Verb};

/// Asks for lines.
pub struct Prompt;

impl Prompt {
    /// Knows nothing: without an editor there is nothing to complete, and nothing is remembered.
    ///
    /// # Errors
    /// None, as standard input is always there.
    pub fn new(_: &'static [Verb], _: &'static str, _: &str) -> io::Result<Self> {
        Ok(Self)
    }

    /// Forgets the names: there is no completion.
    pub fn know(&mut self, _: Vec<String>) {}

    /// The next line. The prompt is shown to a person only.
    pub fn read(&mut self, prompt: &str) -> PromptLine {
        if io::stdin().is_terminal() {
            let mut out = anstream::stdout();
            // a person who does not see it may still type
            let _ = write!(out, "{prompt}").and_then(|()| out.flush());
        }
        let mut line = String::new();
        match io::stdin().lock().read_line(&mut line) {
            Ok(0) | Err(_) => PromptLine::End,
            Ok(_) => PromptLine::Text(line.trim_end_matches(['\r', '\n']).to_owned()),
        }
    }

    /// Remembers nothing.
    pub fn keep(&mut self) {}
}
