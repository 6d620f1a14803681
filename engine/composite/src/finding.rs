//! Where findings are collected.

use asmotion_diagnostics::{Finding, Report};

/// Collects findings.
pub trait Findings {
    /// Adds a finding.
    fn found(&mut self, finding: impl Finding);
}

impl Findings for Report {
    fn found(&mut self, finding: impl Finding) {
        self.push(finding.diagnostic());
    }
}
