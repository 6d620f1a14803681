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
    let finding = match similar {
        Some((_, declared)) => finding.label(*declared, "similar name declared here"),
        None => finding,
    };
    let name = similar.as_ref().map(|(name, _)| &**name);
    finding.did_you_mean_or(at, name, help)
}
