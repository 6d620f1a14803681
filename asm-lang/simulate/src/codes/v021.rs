use crate::failed_condition::FailedCondition;
use crate::failed_condition::{failure_time, holds};
use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};

/// Invariant of the scenario failed
///
/// An invariant of the scenario must hold in the initial state and after each step.
///
/// ```asm
/// asm example
/// import StandardLibrary
/// signature:
///   monitored wish: Integer
///   controlled n: Integer
/// definitions:
///   main rule r_Main = choose $x in {1 : 3} with $x != wish do n := $x
/// ```
///
/// ```avalla wrong
/// scenario example
/// load example.asm
///
/// invariant small: isUndef(n) or n < 2;
/// set wish := 1;
/// pick $x in r_Main := 2;
/// step
/// ```
///
/// Corrected:
///
/// ```avalla corrected
/// scenario example
/// load example.asm
///
/// invariant small: isUndef(n) or n < 3;
/// set wish := 1;
/// pick $x in r_Main := 2;
/// step
/// ```
#[derive(Debug, thiserror::Error, Coded)]
#[code(V021, error)]
#[error("the invariant `{name}` {} {}", holds(seen), failure_time(*steps))]
pub(crate) struct ScenarioInvariantFailed<'a> {
    pub name: &'a str,
    pub seen: &'a FailedCondition,
    pub steps: u64,
    pub at: Span,
}

impl Finding for ScenarioInvariantFailed<'_> {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        self.seen.explain(diagnostic).label(self.at, "found here")
    }
}
