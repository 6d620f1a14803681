//! Findings: facts that become diagnostics.

use crate::code::Coded;
use crate::diagnostic::Diagnostic;
use std::fmt;

/// A finding as facts: `Display` is the message, [`Finding::explain`] adds the labels and the fix.
pub trait Finding: Coded + fmt::Display {
    /// Adds labels, notes, helps and a fix to a diagnostic that has only its code and message.
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic;

    /// Renders the finding as a [`Diagnostic`].
    fn diagnostic(&self) -> Diagnostic {
        self.explain(Diagnostic::new(self.code(), self))
    }
}
