//! Helpers for findings: text with its span, and fixes.

use asmotion_diagnostics::{Applicability, Edit, Fix, Span};

/// A piece of the source text with its span.
pub(crate) type SpannedText = (String, Span);

/// Creates a fix of several edits that keep the meaning.
pub(crate) fn all_sure(title: &str, edits: &[Edit]) -> Fix {
    Fix {
        title: title.to_owned(),
        edits: edits.to_vec(),
        applicability: Applicability::Sure,
    }
}
