//! A line editor with completion and history.

use std::path::PathBuf;

use rustyline::completion::Completer;
use rustyline::error::ReadlineError;
use rustyline::highlight::Highlighter;
use rustyline::hint::Hinter;
use rustyline::history::DefaultHistory;
use rustyline::validate::Validator;
use rustyline::{Context, Editor, Helper};

use super::{PromptLine, Verb};

/// Reads lines.
pub struct Prompt {
    editor: Editor<Words, DefaultHistory>,
    /// History file, if input is a terminal.
    history_file: Option<PathBuf>,
}

impl Prompt {
    /// Creates a prompt with these verbs. Names consist of letters, digits and `signs`; the history is kept in the file
    /// `history_file`.
    pub fn new(
        verbs: &'static [Verb],
        signs: &'static str,
        memory: &str,
    ) -> rustyline::Result<Self> {
        let mut editor = Editor::new()?;
        editor.set_helper(Some(Words {
            verbs,
            signs,
            names: Vec::new(),
        }));
        let memory = std::io::IsTerminal::is_terminal(&std::io::stdin())
            .then(|| history_path(memory))
            .flatten();
        if let Some(path) = &memory {
            // the file does not exist in the first session
            let _ = editor.load_history(path);
        }
        Ok(Self {
            editor,
            history_file: memory,
        })
    }

    /// Replaces the names that are completed.
    pub fn set_names(&mut self, mut names: Vec<String>) {
        names.sort();
        names.dedup();
        if let Some(words) = self.editor.helper_mut() {
            words.names = names;
        }
    }

    /// Reads the next line.
    pub fn read(&mut self, prompt: &str) -> PromptLine {
        match self.editor.readline(prompt) {
            Ok(line) => {
                let _ = self.editor.add_history_entry(line.as_str());
                PromptLine::Text(line)
            }
            Err(ReadlineError::Interrupted) => PromptLine::Nothing,
            Err(_) => PromptLine::End,
        }
    }

    /// Saves the history, if possible.
    pub fn save_history(&mut self) {
        if let Some(path) = &self.history_file {
            let _ = path.parent().map(std::fs::create_dir_all);
            let _ = self.editor.save_history(path);
        }
    }
}

/// Path of the history in the state folder of the XDG base directories.
fn history_path(name: &str) -> Option<PathBuf> {
    let state = std::env::var_os("XDG_STATE_HOME").map(PathBuf::from);
    let home = || std::env::var_os("HOME").map(|home| PathBuf::from(home).join(".local/state"));
    let state = state.filter(|path| path.is_absolute()).or_else(home)?;
    Some(state.join("asmotion").join(name))
}

/// Words for completion: verbs, then names.
struct Words {
    verbs: &'static [Verb],
    signs: &'static str,
    names: Vec<String>,
}

impl Completer for Words {
    type Candidate = String;

    fn complete(
        &self,
        line: &str,
        position: usize,
        _context: &Context<'_>,
    ) -> rustyline::Result<(usize, Vec<String>)> {
        let before = &line[..position];
        let is_letter = |letter: char| letter.is_alphanumeric() || self.signs.contains(letter);
        let start = before.trim_end_matches(is_letter).len();
        let prefix = &before[start..];
        let verbs = self
            .verbs
            .iter()
            .map(|verb| verb.name)
            .filter(|_| before[..start].trim().is_empty());
        let names = self.names.iter().map(String::as_str);
        let candidates = verbs.chain(names).filter(|name| name.starts_with(prefix));
        Ok((start, candidates.map(str::to_owned).collect()))
    }
}

impl Hinter for Words {
    type Hint = String;
}
impl Highlighter for Words {}
impl Validator for Words {}
impl Helper for Words {}
