//! Collection of diagnostics.

use asmotion_diagnostics::{Finding, Report};

/// A collection of diagnostics.
pub trait Findings {
    /// Adds a diagnostic.
    fn found(&mut self, finding: impl Finding);
}

impl Findings for Report {
    fn found(&mut self, finding: impl Finding) {
        self.push(finding.diagnostic());
    }
}
