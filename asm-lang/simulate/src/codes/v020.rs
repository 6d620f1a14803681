use crate::failed_condition::FailedCondition;
use crate::failed_condition::{failure_time, holds};
use asmotion_diagnostics::{Coded, Diagnostic, Finding};

/// Check failed
///
/// The condition of the `check` is false or undef. The message shows the values it reads and the
/// updates of the last step.
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
/// set wish := 1;
/// pick $x in r_Main := 2;
/// step
/// check n = 3;
/// ```
///
/// Corrected:
///
/// ```avalla corrected
/// scenario example
/// load example.asm
///
/// set wish := 1;
/// pick $x in r_Main := 2;
/// step
/// check n = 2;
/// ```
#[derive(Debug, thiserror::Error, Coded)]
#[code(V020, error)]
#[error("the check {} {}", holds(seen), failure_time(*steps))]
pub(crate) struct CheckFailed<'a> {
    pub seen: &'a FailedCondition,
    pub steps: u64,
}

impl Finding for CheckFailed<'_> {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        self.seen.explain(diagnostic)
    }
}
