//! What a stage has to say about places in the sources.

use crate::code::Code;
use crate::fix::Fix;
use crate::span::Span;

/// How bad it is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Severity {
    /// Nothing can be built from this.
    Error,
    /// It works, and is probably not what was meant.
    Warning,
}

/// A place and what is to be seen there.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Label {
    /// The place.
    pub span: Span,
    /// What is to be seen there; lower case, no full stop.
    pub text: String,
}

/// One finding: the fact, the places, the way out.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Diagnostic {
    /// How bad it is.
    pub severity: Severity,
    /// The stable code.
    pub code: &'static Code,
    /// The fact in the user's words; lower case, no full stop.
    pub message: String,
    /// The place of the finding, and what is to be seen there.
    pub primary: Option<Label>,
    /// Other places that matter, in any file.
    pub secondary: Vec<Label>,
    /// Facts that explain it.
    pub notes: Vec<String>,
    /// Ways out in words.
    pub helps: Vec<String>,
    /// A way out that a machine can take.
    pub fix: Option<Fix>,
}

impl Diagnostic {
    /// A message with its code, and no place yet.
    pub fn new(code: &'static Code, message: impl ToString) -> Self {
        Self {
            severity: code.severity,
            code,
            message: message.to_string(),
            primary: None,
            secondary: Vec::new(),
            notes: Vec::new(),
            helps: Vec::new(),
            fix: None,
        }
    }

    /// Whether it has one of these codes.
    pub fn is_any(&self, codes: &[&Code]) -> bool {
        codes.contains(&self.code)
    }

    /// Adds a place: the first one is the primary place, the others are secondary.
    #[must_use]
    pub fn label(mut self, span: Span, text: impl Into<String>) -> Self {
        let label = Label {
            span,
            text: text.into(),
        };
        if self.primary.is_none() {
            self.primary = Some(label);
        } else {
            self.secondary.push(label);
        }
        self
    }

    /// Adds a fact that explains it.
    #[must_use]
    pub fn note(mut self, text: impl Into<String>) -> Self {
        self.notes.push(text.into());
        self
    }

    /// Adds a way out in words.
    #[must_use]
    pub fn help(mut self, text: impl Into<String>) -> Self {
        self.helps.push(text.into());
        self
    }

    /// Replaces one place: a way out that a machine may take without asking.
    #[must_use]
    pub fn fix(self, title: impl Into<String>, span: Span, text: impl Into<String>) -> Self {
        self.with_fix(Fix::sure(title, span, text))
    }

    /// Replaces one place: a way out that a person decides on, as in "did you mean".
    #[must_use]
    pub fn guess(self, title: impl Into<String>, span: Span, text: impl Into<String>) -> Self {
        self.with_fix(Fix::maybe(title, span, text))
    }

    /// Sets the way out that a machine can take.
    #[must_use]
    pub fn with_fix(mut self, fix: Fix) -> Self {
        self.fix = Some(fix);
        self
    }
}

/// All findings of a stage, in the order they were made.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Report {
    /// The findings.
    pub diagnostics: Vec<Diagnostic>,
}

impl FromIterator<Diagnostic> for Report {
    fn from_iter<T: IntoIterator<Item = Diagnostic>>(findings: T) -> Self {
        Self {
            diagnostics: findings.into_iter().collect(),
        }
    }
}

impl Report {
    /// Nothing found yet.
    pub fn new() -> Self {
        Self::default()
    }

    /// Adds a finding.
    pub fn push(&mut self, diagnostic: Diagnostic) {
        self.diagnostics.push(diagnostic);
    }

    /// Adds all findings of another report.
    pub fn extend(&mut self, other: Report) {
        self.diagnostics.extend(other.diagnostics);
    }

    /// Whether an error is among the findings.
    pub fn has_errors(&self) -> bool {
        self.diagnostics
            .iter()
            .any(|finding| finding.severity == Severity::Error)
    }

    /// How many findings have this severity.
    pub fn count(&self, severity: Severity) -> usize {
        self.diagnostics
            .iter()
            .filter(|finding| finding.severity == severity)
            .count()
    }

    /// Sorts by place and drops findings that say the same about the same place.
    pub fn finish(mut self) -> Self {
        self.diagnostics
            .sort_by_key(|finding| finding.primary.as_ref().map(|label| label.span));
        self.diagnostics.dedup();
        self
    }
}
