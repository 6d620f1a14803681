use asmotion_diagnostics::{Coded, Diagnostic, Finding};

use crate::failed_condition::FailedCondition;

/// `step until` did not end
///
/// `step until` runs steps until its condition holds, at most `--max-steps`. The message shows the
/// values that the condition reads at the end.
#[derive(Debug, thiserror::Error, Coded)]
#[code(V022, error)]
#[error("`step until` did not end within {limit} steps")]
pub(crate) struct UntilDidNotEnd<'a> {
    pub limit: u64,
    pub seen: &'a FailedCondition,
}

impl Finding for UntilDidNotEnd<'_> {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        self.seen
            .explain(diagnostic)
            .help("check the condition, set the inputs that make it true, or raise `--max-steps`")
    }
}
