//! What was seen where a condition of a scenario did not hold, and other parts of messages.

use asmotion_diagnostics::{Diagnostic, Span};
use std::sync::Arc;

/// What was seen where a condition did not hold.
#[derive(Clone, Debug, Default)]
pub struct FailedCondition {
    /// The condition.
    pub condition: Span,
    /// Its value: false or undef.
    pub value: String,
    /// The locations it reads, and their values.
    pub parts: Vec<(Span, String)>,
    /// What the last step wrote: `location := value`.
    pub written: Vec<String>,
}

/// More updates than this are not listed in a message.
const MAX_WRITTEN: usize = 12;

impl FailedCondition {
    /// Adds the values that were read, and what the last step wrote.
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
            written => finding.note(format!("the step before wrote {}", written.join(", "))),
        }
    }
}

/// Offers a similar name, if there is one.
pub(crate) fn meant(finding: Diagnostic, at: Span, similar: &Option<Arc<str>>) -> Diagnostic {
    match similar {
        Some(name) => finding.guess(format!("did you mean `{name}`?"), at, name.to_string()),
        None => finding,
    }
}

/// How a condition that is false or undef failed.
pub(crate) fn holds(seen: &FailedCondition) -> &'static str {
    match seen.value.as_str() {
        "undef" => "is undef",
        _ => "does not hold",
    }
}

/// After how many steps.
pub(crate) fn when(steps: u64) -> String {
    match steps {
        0 => "before the first step".to_owned(),
        steps => format!("after step {steps}"),
    }
}
