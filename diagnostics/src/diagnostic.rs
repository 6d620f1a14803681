//! Diagnostics: findings in words, with spans in the sources.

use crate::code::Code;
use crate::fix::Fix;
use crate::severity::Severity;
use crate::similar::did_you_mean;
use crate::span::Span;

/// A span and a text that annotates it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Label {
    /// The annotated range of the source.
    pub span: Span,
    /// Annotation; lower case, without a full stop.
    pub text: String,
}

/// One finding in words: message, labelled spans, and suggestions.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Diagnostic {
    /// Copied from the code; decides whether the stage fails.
    pub severity: Severity,
    /// The stable code, which leads to the documentation page.
    pub code: &'static Code,
    /// The fact in the user's words; lower case, without a full stop.
    pub message: String,
    /// The main label, shown first. `None` if the finding has no place in a source text.
    pub primary: Option<Label>,
    /// Further labels, in any file, in the order they were added.
    pub secondary: Vec<Label>,
    /// Facts that explain the finding, each rendered as `= note: …`.
    pub notes: Vec<String>,
    /// Suggestions in words, each rendered as `help: …` below the finding.
    pub helps: Vec<String>,
    /// A suggestion as edits, which a tool can apply.
    pub fix: Option<Fix>,
}

impl Diagnostic {
    /// Creates a diagnostic with a code and a message, without labels.
    pub fn new(code: &'static Code, message: impl ToString) -> Self {
        Self::bare(code, message.to_string())
    }

    fn bare(code: &'static Code, message: String) -> Self {
        Self {
            severity: code.severity,
            code,
            message,
            primary: None,
            secondary: Vec::new(),
            notes: Vec::new(),
            helps: Vec::new(),
            fix: None,
        }
    }

    /// Returns `true` if the diagnostic has one of these codes.
    pub fn is_any(&self, codes: &[&Code]) -> bool {
        codes.contains(&self.code)
    }

    /// Adds a label. The first one becomes the primary label, the others secondary.
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

    /// Adds a fact that explains the finding.
    #[must_use]
    pub fn note(mut self, text: impl Into<String>) -> Self {
        self.notes.push(text.into());
        self
    }

    /// Adds a suggestion in words.
    #[must_use]
    pub fn help(mut self, text: impl Into<String>) -> Self {
        self.helps.push(text.into());
        self
    }

    /// Suggests one replacement that a tool may apply without asking ([`Fix::sure`]).
    #[must_use]
    pub fn fix(self, title: impl Into<String>, span: Span, text: impl Into<String>) -> Self {
        self.with_fix(Fix::sure(title, span, text))
    }

    /// Suggests one replacement that the user has to confirm, as in "did you mean"
    /// ([`Fix::maybe`]).
    #[must_use]
    pub fn guess(self, title: impl Into<String>, span: Span, text: impl Into<String>) -> Self {
        self.with_fix(Fix::maybe(title, span, text))
    }

    /// Suggests the similar name in place of the text at `at`; adds nothing for `None`.
    #[must_use]
    pub fn did_you_mean(self, at: Span, name: Option<&str>) -> Self {
        match name {
            Some(name) => self.guess(did_you_mean(name), at, name),
            None => self,
        }
    }

    /// Suggests the similar name as [`Diagnostic::did_you_mean`] does, or `help` for `None`.
    #[must_use]
    pub fn did_you_mean_or(self, at: Span, name: Option<&str>, help: impl Into<String>) -> Self {
        match name {
            Some(_) => self.did_you_mean(at, name),
            None => self.help(help),
        }
    }

    /// Sets the suggested edits, replacing those set before.
    #[must_use]
    pub fn with_fix(mut self, fix: Fix) -> Self {
        self.fix = Some(fix);
        self
    }
}

/// The findings of a stage, in the order they were made.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Report {
    /// Findings of both severities; unsorted until [`Report::finish`].
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
    /// Creates an empty report.
    pub fn new() -> Self {
        Self::default()
    }

    /// Appends a finding.
    pub fn push(&mut self, diagnostic: Diagnostic) {
        self.diagnostics.push(diagnostic);
    }

    /// Appends the findings of another report.
    pub fn extend(&mut self, other: Report) {
        self.diagnostics.extend(other.diagnostics);
    }

    /// Returns `true` if a finding is an error.
    pub fn has_errors(&self) -> bool {
        self.diagnostics
            .iter()
            .any(|finding| finding.severity == Severity::Error)
    }

    /// Returns the number of findings with this severity.
    pub fn count(&self, severity: Severity) -> usize {
        self.diagnostics
            .iter()
            .filter(|finding| finding.severity == severity)
            .count()
    }

    /// Sorts the findings by their primary span and removes duplicates.
    pub fn finish(mut self) -> Self {
        self.diagnostics
            .sort_by_key(|finding| finding.primary.as_ref().map(|label| label.span));
        self.diagnostics.dedup();
        self
    }
}
