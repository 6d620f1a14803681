//! Observed values that explain why a condition of a scenario failed.

use asmotion_diagnostics::{Diagnostic, Span};

/// A condition that failed, with the observed values.
#[derive(Clone, Debug, Default)]
pub struct FailedCondition {
    /// Span of the condition.
    pub condition: Span,
    /// Its value as text: false or undef.
    pub value: String,
    /// Spans of the locations it reads, with their values.
    pub parts: Vec<(Span, String)>,
    /// Updates of the last step, as `location := value`.
    pub written: Vec<String>,
}

/// Limit for the number of updates listed in a message.
const MAX_WRITTEN: usize = 12;

impl FailedCondition {
    /// Adds the observed values and the updates of the last step to a diagnostic.
    pub(crate) fn explain(&self, finding: Diagnostic) -> Diagnostic {
        let mut finding = finding.label(self.condition, format!("is {}", self.value));
        for (span, value) in &self.parts {
            finding = finding.label(*span, format!("is {value}"));
        }
        let more = self.written.len().saturating_sub(MAX_WRITTEN);
        let mut written: Vec<&str> = self
            .written
            .iter()
            .take(MAX_WRITTEN)
            .map(|it| &**it)
            .collect();
        let rest = format!("and {more} more");
        if more > 0 {
            written.push(&rest);
        }
        match written.as_slice() {
            [] => finding,
            written => finding.note(format!("the previous step wrote {}", written.join(", "))),
        }
    }
}

/// Returns the predicate for a condition that is false or undef.
pub(crate) fn holds(seen: &FailedCondition) -> &'static str {
    match seen.value.as_str() {
        "undef" => "is undef",
        _ => "does not hold",
    }
}

/// Returns the time of a failure in words.
pub(crate) fn failure_time(steps: u64) -> String {
    match steps {
        0 => "before the first step".to_owned(),
        steps => format!("after step {steps}"),
    }
}
