//! What is wrong with a file, collected while it is read.

use crate::codes::l010::StraySemicolon;
use crate::codes::l039::NestedTooDeep;
use crate::codes::l062::TooManyErrors;
use asmotion_diagnostics::{Code, Diagnostic, FileId, Finding, Report, Severity, Span};
use std::cell::{Cell, RefCell};

/// A file with so many errors is not read to its end.
const MAX_ERRORS: u32 = 50;

/// Nor is a file with so many, counting those that only follow from others.
const MAX_CAUGHT: u32 = 1000;

/// What is beyond so many warnings is not worth telling.
const MAX_WARNINGS: u32 = 100;

/// Findings that are reported at most once a file.
const ONCE: &[&Code] = &[StraySemicolon::CODE, NestedTooDeep::CODE];

/// A parser that takes so many tokens without building a node is lost.
const MAX_IDLE: u32 = 10_000;

/// The errors and warnings of one file; the lexer and the parser write to it in turns.
#[derive(Debug, Default)]
pub(crate) struct SyntaxFindings {
    file: FileId,
    found: RefCell<Vec<Diagnostic>>,
    errors: Cell<u32>,
    warnings: Cell<u32>,
    /// The errors the parser caught, told or not.
    caught: Cell<u32>,
    /// The tokens the parser took since it built something.
    idle: Cell<u32>,
}

impl SyntaxFindings {
    /// Nothing found yet.
    pub(crate) fn new(file: FileId) -> Self {
        Self {
            file,
            ..Self::default()
        }
    }

    /// A place in the file.
    pub(crate) fn span(&self, start: usize, end: usize) -> Span {
        Span::new(self.file, start, end)
    }

    /// Adds a finding, as long as there is room for it.
    pub(crate) fn report(&self, finding: impl Finding) {
        self.add(finding.diagnostic());
    }

    /// Adds a finding that is in words already.
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

    /// Notes that the parser caught an error, whether or not it is worth a word.
    pub(crate) fn caught(&self, at: Span) {
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

    /// Whether there are too many errors to go on.
    pub(crate) fn is_full(&self) -> bool {
        self.errors.get() >= MAX_ERRORS || self.caught.get() >= MAX_CAUGHT
    }

    /// Takes back the last finding if it has this code and stands behind `start`.
    pub(crate) fn retract(&self, code: &Code, start: usize) {
        let wrong = |last: &mut Diagnostic| last.is_any(&[code]) && place(last) >= start;
        if self.found.borrow_mut().pop_if(wrong).is_some() {
            self.errors.update(|errors| errors.saturating_sub(1));
        }
    }

    /// Whether an error was reported at one of these bytes.
    pub(crate) fn error_between(&self, start: usize, end: usize) -> bool {
        let found = self.found.borrow();
        found.iter().rev().any(|finding| {
            finding.severity == Severity::Error && (start..=end).contains(&place(finding))
        })
    }

    /// Whether an error was reported at all.
    pub(crate) fn has_errors(&self) -> bool {
        self.errors.get() > 0
    }

    /// Notes that the parser takes a token; true when it has not built anything for long.
    pub(crate) fn token_taken(&self) -> bool {
        self.idle.update(|idle| idle.saturating_add(1));
        self.idle.get() > MAX_IDLE
    }

    /// Notes that the parser built something.
    pub(crate) fn node_built(&self) {
        self.idle.set(0);
    }

    /// All that was found, by place.
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
