//! Diagnostic codes and their pages.

use crate::diagnostic::{Diagnostic, Severity};
use std::fmt;

/// A stable diagnostic code and its page, which `asmotion check --explain` prints.
///
/// A code is never given to another meaning. `#[derive(Coded)]` makes one from the doc comment of a
/// finding: title, explanation, and a small wrong program with the same one mended, each in a fenced block
/// whose info string says which (`asm wrong`, `asm mended`). Tests try both.
#[derive(Debug)]
pub struct Code {
    /// Family and number, as in `A014`.
    pub name: &'static str,
    /// Whether such a finding stops the build.
    pub severity: Severity,
    /// The meaning in a few words, without full stop.
    pub title: &'static str,
    /// The rest of the page, in Markdown.
    pub text: &'static str,
}

impl Code {
    /// The whole page in Markdown, with its heading.
    pub fn page(&self) -> String {
        let suffix = match self.severity {
            Severity::Error => "",
            Severity::Warning => " (warning)",
        };
        format!("# {}: {}{suffix}\n\n{}", self.name, self.title, self.text)
    }

    /// The text of the fenced block with this info string, as in `asm wrong`.
    pub fn example(&self, info: &str) -> Option<&'static str> {
        let (_, rest) = self.text.split_once(&format!("```{info}\n"))?;
        rest.split_once("```").map(|(example, _)| example)
    }
}

impl fmt::Display for Code {
    fn fmt(&self, to: &mut fmt::Formatter<'_>) -> fmt::Result {
        to.write_str(self.name)
    }
}

impl PartialEq for Code {
    fn eq(&self, other: &Self) -> bool {
        self.name == other.name
    }
}

impl Eq for Code {}

impl PartialEq<str> for Code {
    fn eq(&self, name: &str) -> bool {
        self.name == name
    }
}

/// The link from a finding to its code; derived from the doc comment and `#[code(A014, error)]`.
pub trait Coded {
    /// The code of this finding.
    fn code(&self) -> &'static Code;
}

/// A finding as facts: `Display` is the message, [`Finding::explain`] adds the places and the way out.
pub trait Finding: Coded + fmt::Display {
    /// Adds labels, notes, helps and a fix to a diagnostic that has code and message.
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic;

    /// The finding in words.
    fn diagnostic(&self) -> Diagnostic {
        self.explain(Diagnostic::new(self.code(), self))
    }
}
