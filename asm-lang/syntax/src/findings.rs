//! What is wrong with a file, collected while it is read.

use crate::error::SyntaxError;
use source::{Diagnostic, FileId, Report, Severity, Span};
use std::cell::{Cell, RefCell};

/// A file with more errors than this is not read to its end.
const MAX_ERRORS: usize = 50;

/// Nor is a file with more than this, counting those that only follow from others.
const MAX_CAUGHT: u32 = 1000;

/// A parser that takes so many tokens without building a node is lost.
const MAX_IDLE: u32 = 10_000;

/// The errors and warnings of one file; the lexer and the parser write to it in turns.
#[derive(Debug, Default)]
pub(crate) struct Findings {
    file: FileId,
    found: RefCell<Vec<Diagnostic>>,
    caught: Cell<u32>,
    idle: Cell<u32>,
}

impl Findings {
    /// Nothing found yet.
    pub(crate) fn new(file: FileId) -> Self {
        Self { file, ..Self::default() }
    }

    /// A place in the file.
    pub(crate) fn span(&self, start: usize, end: usize) -> Span {
        Span::new(self.file, start, end)
    }

    /// Adds a finding. What every file needs to be told once is told once; the last one that is
    /// told is that there are too many.
    pub(crate) fn report(&self, error: SyntaxError) {
        let once = matches!(error, SyntaxError::TooDeep { .. } | SyntaxError::Semicolon { .. });
        let finding = error.diagnostic();
        if self.is_full() || (once && self.has(finding.code)) {
            return;
        }
        let place = finding.primary.as_ref().map_or(self.span(0, 0), |label| label.span);
        self.found.borrow_mut().push(finding);
        if self.errors() == MAX_ERRORS {
            self.found.borrow_mut().push(SyntaxError::TooMany { at: place }.diagnostic());
        }
    }

    /// Takes back the last finding if it has this code and stands behind `start`.
    pub(crate) fn retract(&self, code: &str, start: usize) {
        self.found
            .borrow_mut()
            .pop_if(|last| last.code == code && place(last) >= start);
    }

    /// Whether an error was reported between the two places.
    pub(crate) fn error_between(&self, start: usize, end: usize) -> bool {
        let found = self.found.borrow();
        found.iter().rev().any(|finding| {
            finding.severity == Severity::Error && (start..=end).contains(&place(finding))
        })
    }

    /// Whether an error was reported at all.
    pub(crate) fn has_errors(&self) -> bool {
        self.errors() > 0
    }

    /// Notes that the parser caught an error, and whether it is worth a word.
    pub(crate) fn caught(&self, at: Span) {
        self.caught.update(|caught| caught + 1);
        if self.caught.get() == MAX_CAUGHT && self.errors() < MAX_ERRORS {
            self.found.borrow_mut().push(SyntaxError::TooMany { at }.diagnostic());
        }
    }

    /// Whether there are too many errors to go on.
    pub(crate) fn is_full(&self) -> bool {
        self.caught.get() >= MAX_CAUGHT || self.errors() > MAX_ERRORS
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
        Report { diagnostics: self.found.into_inner() }.finish()
    }

    fn has(&self, code: &str) -> bool {
        self.found.borrow().iter().any(|finding| finding.code == code)
    }

    fn errors(&self) -> usize {
        let found = self.found.borrow();
        found.iter().filter(|finding| finding.severity == Severity::Error).count()
    }
}

fn place(finding: &Diagnostic) -> usize {
    finding.primary.as_ref().map_or(0, |label| label.span.start as usize)
}
