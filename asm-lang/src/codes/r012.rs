use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};

/// Collection too large
///
/// An interval or a domain has too many elements to enumerate.
///
/// ```asm wrong
/// asm example
/// import StandardLibrary
/// signature:
///   controlled n: Integer
/// definitions:
///   main rule r_Main = n := size({1 : 99999999})
/// ```
///
/// Corrected:
///
/// ```asm corrected
/// asm example
/// import StandardLibrary
/// signature:
///   controlled n: Integer
/// definitions:
///   main rule r_Main = n := 99999999
/// ```
#[derive(Debug, thiserror::Error, Coded)]
#[code(R012, error)]
#[error("a collection of {count} elements is too large {when}")]
pub(crate) struct CollectionTooLarge {
    pub count: u64,
    pub when: String,
    pub at: Span,
}

impl Finding for CollectionTooLarge {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        diagnostic
            .label(self.at, "built here")
            .help("range over a smaller domain")
    }
}
