use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};

/// Types too large
///
/// The fields of nested types are counted every time the type is used. Use lists (`name[]`) instead of
/// many fields.
#[derive(Debug, thiserror::Error, Coded)]
#[code(C116, error)]
#[error("message types have more than {MAX_FIELDS} fields, or nest deeper than {MAX_DEPTH}")]
pub(crate) struct TypesTooLarge {
    pub at: Span,
}

impl Finding for TypesTooLarge {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        diagnostic
            .label(self.at, "limit exceeded here")
            .help("send large values as bytes, or by name")
    }
}

/// Maximum number of fields of a message. Schemas are trees, so a short file that repeatedly nests types can describe
/// an exponentially large one.
pub(crate) const MAX_FIELDS: usize = 100_000;

/// Maximum nesting depth of a message.
pub(crate) const MAX_DEPTH: usize = 32;
