//! Findings are facts first; their words are made once, here and in the enums of the stages.

use asmotion_diagnostics::{Diagnostic, Report};

/// A finding of a stage, as facts.
pub(crate) trait Finding {
    /// The same in words, with its places and a way out.
    fn diagnostic(&self) -> Diagnostic;

    /// Whether it is about a value that was set from outside all files.
    fn is_outside(&self) -> bool {
        false
    }
}

/// Collects findings.
pub(crate) trait Findings {
    /// Adds a finding.
    fn found(&mut self, finding: impl Finding);
}

impl Findings for Report {
    fn found(&mut self, finding: impl Finding) {
        self.push(finding.diagnostic());
    }
}
