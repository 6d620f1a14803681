//! Fixes: edits that a tool can apply to resolve a finding.

use crate::span::Span;

/// Confidence in a fix: decides if a tool may apply it unattended.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Applicability {
    /// The fix keeps the meaning, or leads to the only lawful one. Applied by [`apply`](crate::apply()).
    Sure,
    /// The fix may not be what the user meant, so the user decides.
    Maybe,
}

/// Replaces a range of the source. An empty `text` deletes, an empty `span` inserts.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Edit {
    /// The range to replace.
    pub span: Span,
    /// New content of the range.
    pub text: String,
}

/// Edits that together resolve a finding; applied all or not at all.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Fix {
    /// Message shown with the edits, as in "did you mean `speed`?".
    pub title: String,
    /// Edits of one file that do not overlap.
    pub edits: Vec<Edit>,
    /// [`Applicability::Sure`] if a tool may apply the edits without asking.
    pub applicability: Applicability,
}

impl Fix {
    /// Creates a fix that replaces one range and may be applied without asking.
    pub fn sure(title: impl Into<String>, span: Span, text: impl Into<String>) -> Self {
        Self {
            title: title.into(),
            edits: vec![Edit {
                span,
                text: text.into(),
            }],
            applicability: Applicability::Sure,
        }
    }

    /// Creates a fix that replaces one range after the user has agreed.
    pub fn maybe(title: impl Into<String>, span: Span, text: impl Into<String>) -> Self {
        Self {
            applicability: Applicability::Maybe,
            ..Self::sure(title, span, text)
        }
    }

    /// Adds the replacement of another range.
    #[must_use]
    pub fn and(mut self, span: Span, text: impl Into<String>) -> Self {
        self.edits.push(Edit {
            span,
            text: text.into(),
        });
        self
    }
}
