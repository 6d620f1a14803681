//! Results of scenarios.

use super::difference::SnapshotDifference;
use crate::exit::Exit;
use asmotion_lang::coverage::Coverage;
use asmotion_lang::simulate::scenario::Verdict;
use asmotion_lang::{Report, Sources};
use std::path::PathBuf;
use std::time::Duration;

/// The result of one scenario.
pub struct TestResult {
    /// Path as it was found.
    pub path: PathBuf,
    /// Name of the scenario.
    pub name: String,
    pub end: TestEnd,
    pub steps: u64,
    pub checks: u64,
    pub duration: Duration,
    /// Findings, and the texts they refer to.
    pub report: Report,
    pub sources: Sources,
    /// Coverage, if requested.
    pub coverage: Option<Coverage>,
    /// Difference between a snapshot and the run, if there is one.
    pub difference: Option<SnapshotDifference>,
}

impl TestResult {
    /// A result that is `Unusable` until the scenario has run.
    pub fn unusable(path: PathBuf) -> Self {
        Self {
            path,
            name: String::new(),
            end: TestEnd::Unusable,
            steps: 0,
            checks: 0,
            duration: Duration::ZERO,
            report: Report::new(),
            sources: Sources::new(),
            coverage: None,
            difference: None,
        }
    }
}

/// Outcome of a scenario.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TestEnd {
    /// Ran to a verdict.
    Ran(Verdict),
    /// Cannot be run.
    Unusable,
}

impl TestEnd {
    pub fn word(self) -> &'static str {
        match self {
            Self::Ran(verdict) => verdict.word(),
            Self::Unusable => "unusable",
        }
    }

    pub fn exit(self) -> Exit {
        match self {
            Self::Ran(Verdict::Pass) => Exit::Ok,
            Self::Ran(Verdict::Fail | Verdict::Invariant | Verdict::Fault) => Exit::Findings,
            Self::Unusable => Exit::Usage,
        }
    }
}
