//! Diagnostic codes and their pages.

use crate::severity::Severity;
use std::fmt;

/// A stable diagnostic code and its page, printed by `asmotion check --explain`.
///
/// A code keeps its meaning for ever; a retired code is not reused. `#[derive(Coded)]` builds the
/// code from the doc comment of a finding: a title, an explanation, and two fenced blocks, a small
/// wrong program (info string `asm wrong`) and its corrected form (`asm corrected`). Tests check both
/// programs.
#[derive(Debug)]
pub struct Code {
    /// Family and number, as in `A014`. The letter stands for the stage that reports it.
    pub name: &'static str,
    /// Severity of every finding with this code.
    pub severity: Severity,
    /// Title of the page: the meaning in a few words, without a full stop.
    pub title: &'static str,
    /// The page below the title, in Markdown.
    pub text: &'static str,
}

impl Code {
    /// Returns the whole page in Markdown, with its heading.
    pub fn page(&self) -> String {
        let suffix = match self.severity {
            Severity::Error => "",
            Severity::Warning => " (warning)",
        };
        format!("# {}: {}{suffix}\n\n{}", self.name, self.title, self.text)
    }

    /// Returns the text of the fenced block with this info string, as in `asm wrong`, or `None` if
    /// the page has no such block.
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

/// Links a finding to its code; derived from the doc comment and `#[code(A014, error)]`.
pub trait Coded {
    /// Returns the code of this finding.
    fn code(&self) -> &'static Code;
}
