//! The findings about a file, collected while it is parsed.

use crate::codes::l010::StraySemicolon;
use crate::codes::l039::NestedTooDeep;
use crate::codes::l062::TooManyErrors;
use asmotion_diagnostics::{Code, Diagnostic, FileId, Finding, Report, Severity, Span};
use std::cell::{Cell, RefCell};

/// Number of errors after which the rest of the file is not parsed.
const MAX_ERRORS: u32 = 50;

/// Number of errors, including consequences of others, after which the rest of the file is not
/// parsed.
const MAX_CAUGHT: u32 = 1000;

/// Number of warnings after which further ones are dropped.
const MAX_WARNINGS: u32 = 100;

/// Findings that are reported only once for a file.
const ONCE: &[&Code] = &[StraySemicolon::CODE, NestedTooDeep::CODE];

/// Number of tokens without a new node after which the parser is considered stuck.
const MAX_IDLE: u32 = 10_000;

/// The errors and warnings of a file. The lexer and the parser write to it alternately, hence the
/// cells.
#[derive(Debug, Default)]
pub(crate) struct SyntaxFindings {
    file: FileId,
    found: RefCell<Vec<Diagnostic>>,
    errors: Cell<u32>,
    warnings: Cell<u32>,
    /// Number of errors caught by the parser, reported or not.
    caught: Cell<u32>,
    /// Number of tokens since the parser built the last node.
    idle: Cell<u32>,
}

impl SyntaxFindings {
    /// Creates an empty collection for a file.
    pub(crate) fn new(file: FileId) -> Self {
        Self {
            file,
            ..Self::default()
        }
    }

    /// Creates a span in the file.
    pub(crate) fn span(&self, start: usize, end: usize) -> Span {
        Span::new(self.file, start, end)
    }

    /// Adds a finding, up to the limits.
    pub(crate) fn report(&self, finding: impl Finding) {
        self.add(finding.diagnostic());
    }

    /// Adds a finding in words, up to the limits.
    pub(crate) fn add(&self, finding: Diagnostic) {
        let again = ONCE
            .iter()
            .any(|code| finding.is_any(&[code]) && self.has(code));
        if self.is_full() || again {
            return;
        }
        match finding.severity {
            Severity::Error => self.errors.update(|errors| errors + 1),
            Severity::Warning => self.warnings.update(|warnings| warnings + 1),
        }
        let last = finding.primary.as_ref().map(|label| label.span);
        if finding.severity == Severity::Error || self.warnings.get() <= MAX_WARNINGS {
            self.found.borrow_mut().push(finding);
        }
        if let Some(at) = last
            && self.is_full()
        {
            self.give_up(at);
        }
    }

    /// Counts an error caught by the parser, reported or not.
    pub(crate) fn count_error(&self, at: Span) {
        let full = self.is_full();
        self.caught.update(|caught| caught + 1);
        if self.is_full() && !full {
            self.give_up(at);
        }
    }

    fn give_up(&self, at: Span) {
        let finding = TooManyErrors { at }.diagnostic();
        self.found.borrow_mut().push(finding);
    }

    /// Returns `true` if there are too many errors to continue.
    pub(crate) fn is_full(&self) -> bool {
        self.errors.get() >= MAX_ERRORS || self.caught.get() >= MAX_CAUGHT
    }

    /// Removes the last finding if it has this code and is not before `start`.
    pub(crate) fn retract(&self, code: &Code, start: usize) {
        let wrong = |last: &mut Diagnostic| last.is_any(&[code]) && place(last) >= start;
        if self.found.borrow_mut().pop_if(wrong).is_some() {
            self.errors.update(|errors| errors.saturating_sub(1));
        }
    }

    /// Returns `true` if an error was reported at an offset in this range.
    pub(crate) fn error_between(&self, start: usize, end: usize) -> bool {
        let found = self.found.borrow();
        found.iter().rev().any(|finding| {
            finding.severity == Severity::Error && (start..=end).contains(&place(finding))
        })
    }

    /// Returns `true` if an error was reported.
    pub(crate) fn has_errors(&self) -> bool {
        self.errors.get() > 0
    }

    /// Returns `true` if the parser has caught an error, reported or not.
    pub(crate) fn has_caught(&self) -> bool {
        self.caught.get() > 0
    }

    /// Counts a token taken by the parser; returns `true` if the parser seems to be stuck.
    pub(crate) fn token_taken(&self) -> bool {
        self.idle.update(|idle| idle.saturating_add(1));
        self.idle.get() > MAX_IDLE
    }

    /// Records that the parser has built a node.
    pub(crate) fn node_built(&self) {
        self.idle.set(0);
    }

    /// Returns all findings, sorted by position.
    pub(crate) fn finish(self) -> Report {
        let diagnostics = self.found.into_inner();
        Report { diagnostics }.finish()
    }

    fn has(&self, code: &Code) -> bool {
        self.found
            .borrow()
            .iter()
            .any(|finding| finding.is_any(&[code]))
    }
}

fn place(finding: &Diagnostic) -> usize {
    finding
        .primary
        .as_ref()
        .map_or(0, |label| label.span.start as usize)
}
