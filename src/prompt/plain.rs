//! Reads lines from standard input, without completion or history.

use std::io::{self, BufRead, IsTerminal, Write};

use super::{PromptLine, Verb};

/// Reads lines.
pub struct Prompt;

impl Prompt {
    /// Creates a prompt. Without an editor, verbs and history are not used.
    ///
    /// # Errors
    /// Never fails; the signature is that of the editor.
    pub fn new(_: &'static [Verb], _: &'static str, _: &str) -> io::Result<Self> {
        Ok(Self)
    }

    /// Does nothing: there is no completion.
    pub fn set_names(&mut self, _: Vec<String>) {}

    /// Reads the next line. The prompt is printed only on a terminal.
    pub fn read(&mut self, prompt: &str) -> PromptLine {
        if io::stdin().is_terminal() {
            let mut out = anstream::stdout();
            // without a visible prompt the user can still type
            let _ = write!(out, "{prompt}").and_then(|()| out.flush());
        }
        let mut line = String::new();
        match io::stdin().lock().read_line(&mut line) {
            Ok(0) | Err(_) => PromptLine::End,
            Ok(_) => PromptLine::Text(line.trim_end_matches(['\r', '\n']).to_owned()),
        }
    }

    /// Does nothing: there is no history.
    pub fn save_history(&mut self) {}
}
