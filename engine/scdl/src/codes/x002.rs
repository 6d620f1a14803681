use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};

/// Not an SCA composite
///
/// The root element is `<composite>`, in the namespace of SCA 1.0 (`http://www.osoa.org/xmlns/sca/1.0`)
/// or SCA 1.1 (`http://docs.oasis-open.org/ns/opencsa/sca/200912`).
///
/// ```xml wrong
/// <composite name="example"/>
/// ```
///
/// Corrected:
///
/// ```xml corrected
/// <composite xmlns="http://docs.oasis-open.org/ns/opencsa/sca/200912" name="example"/>
/// ```
#[derive(Debug, thiserror::Error, Coded)]
#[code(X002, error)]
#[error("`<{name}>` is not an SCA composite")]
pub(crate) struct NotScdl {
    pub name: String,
    pub at: Span,
}

impl Finding for NotScdl {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        diagnostic
                .label(self.at, "outermost element")
                .help("start the file with `<composite xmlns=\"http://docs.oasis-open.org/ns/opencsa/sca/200912\" name=\"…\">`")
    }
}
