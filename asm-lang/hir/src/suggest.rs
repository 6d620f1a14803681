//! Suggestions for misspelt names.

use asmotion_diagnostics::{Diagnostic, Span};
use std::sync::Arc;

/// Suggests the similar name as a fix; adds `help` if there is none.
pub(crate) fn with_similar(
    finding: Diagnostic,
    at: Span,
    similar: &Option<(Arc<str>, Span)>,
    help: &str,
) -> Diagnostic {
    match similar {
        Some((name, declared)) => finding
            .label(*declared, "a similar name is declared here")
            .guess(format!("did you mean `{name}`?"), at, name.to_string()),
        None => finding.help(help),
    }
}
