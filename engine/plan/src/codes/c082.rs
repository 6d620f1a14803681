use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};

/// Too many components
///
/// Nested composites multiply: each of their components exists once for every time the file is
/// included, also by `for`. Nested composites themselves count, too.
#[derive(Debug, thiserror::Error, Coded)]
#[code(C082, error)]
#[error("more than {MAX_COMPONENTS} components, including nested ones")]
pub(crate) struct TooManyComponents {
    pub at: Span,
}

impl Finding for TooManyComponents {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        diagnostic
            .label(self.at, "limit exceeded here")
            .help("nest fewer composites and use fewer instances; each of them counts")
    }
}

/// Maximum number of components; bounds memory for files that nest exponentially.
pub(crate) const MAX_COMPONENTS: usize = 10_000;
