//! Parts of findings: places with their text, and fixes.

use asmotion_diagnostics::{Applicability, Edit, Fix, Span};

/// A word or a sign of the text and where it stands.
pub(crate) type SpannedText = (String, Span);

/// Edits that keep the meaning.
pub(crate) fn all_sure(title: &str, edits: &[Edit]) -> Fix {
    Fix {
        title: title.to_owned(),
        edits: edits.to_vec(),
        applicability: Applicability::Sure,
    }
}
