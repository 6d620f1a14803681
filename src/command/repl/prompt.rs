//! Lines from a person, with completion and a memory; or from a pipe.

use super::verb::VERBS;
use asm_lang::Session;
use rustyline::completion::Completer;
use rustyline::error::ReadlineError;
use rustyline::highlight::Highlighter;
use rustyline::hint::Hinter;
use rustyline::history::DefaultHistory;
use rustyline::validate::Validator;
use rustyline::{Context, Editor, Helper};
use std::path::PathBuf;

/// What came of asking for a line.
pub enum Line {
    /// A line.
    Text(String),
    /// Given up with Ctrl-C.
    Nothing,
    /// There will be no other one.
    End,
}

/// Asks for lines.
pub struct Prompt {
    editor: Editor<Words, DefaultHistory>,
    /// Where lines are remembered, if a person types them.
    memory: Option<PathBuf>,
}

impl Prompt {
    /// Knows the names of a specification.
    pub fn new(session: &Session) -> rustyline::Result<Self> {
        let mut editor = Editor::new()?;
        editor.set_helper(Some(Words::of(session)));
        let memory = std::io::IsTerminal::is_terminal(&std::io::stdin())
            .then(memory)
            .flatten();
        if let Some(path) = &memory {
            // the first time there is none
            let _ = editor.load_history(path);
        }
        Ok(Self { editor, memory })
    }

    /// The next line.
    pub fn read(&mut self, prompt: &str) -> Line {
        match self.editor.readline(prompt) {
            Ok(line) => {
                let _ = self.editor.add_history_entry(line.as_str());
                Line::Text(line)
            }
            Err(ReadlineError::Interrupted) => Line::Nothing,
            Err(_) => Line::End,
        }
    }

    /// Remembers the lines for the next time, where that is possible.
    pub fn keep(&mut self) {
        if let Some(path) = &self.memory {
            let _ = path.parent().map(std::fs::create_dir_all);
            let _ = self.editor.save_history(path);
        }
    }
}

/// Where lines are remembered: the state folder of the XDG base directories.
fn memory() -> Option<PathBuf> {
    let state = std::env::var_os("XDG_STATE_HOME").map(PathBuf::from);
    let home = || std::env::var_os("HOME").map(|home| PathBuf::from(home).join(".local/state"));
    let state = state.filter(|path| path.is_absolute()).or_else(home)?;
    Some(state.join("asmotion").join("repl_history"))
}

/// The words that can be completed: first the verbs, then the names of the specification.
struct Words {
    names: Vec<String>,
}

impl Words {
    fn of(session: &Session) -> Self {
        let model = &session.specification.model;
        let functions = model
            .own_functions()
            .map(|(_, function)| function.name.to_string());
        let rules = model.rules.iter().filter(|rule| !rule.library);
        let atoms = model.atoms.iter().map(|atom| atom.name.to_string());
        let mut names: Vec<String> = functions
            .chain(rules.map(|rule| rule.name.to_string()))
            .chain(atoms)
            .collect();
        names.sort();
        names.dedup();
        Self { names }
    }
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
        let is_letter = |letter: char| letter.is_alphanumeric() || "_$".contains(letter);
        let start = before.trim_end_matches(is_letter).len();
        let word = &before[start..];
        let verbs = VERBS
            .iter()
            .map(|verb| verb.name)
            .filter(|_| before[..start].trim().is_empty());
        let names = self.names.iter().map(String::as_str);
        let found = verbs.chain(names).filter(|name| name.starts_with(word));
        Ok((start, found.map(str::to_owned).collect()))
    }
}

impl Hinter for Words {
    type Hint = String;
}
impl Highlighter for Words {}
impl Validator for Words {}
impl Helper for Words {}
