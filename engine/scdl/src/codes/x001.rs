use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};

/// Invalid XML
///
/// An SCDL file is XML: close every element, quote every attribute, and write `&` as `&amp;`.
///
/// ```xml wrong
/// <composite xmlns="http://docs.oasis-open.org/ns/opencsa/sca/200912" name="example">
///   <component name="Planner">
/// </composite>
/// ```
///
/// Corrected:
///
/// ```xml corrected
/// <composite xmlns="http://docs.oasis-open.org/ns/opencsa/sca/200912" name="example">
///   <component name="Planner">
///     <implementation.java class="nav.Planner"/>
///   </component>
/// </composite>
/// ```
#[derive(Debug, thiserror::Error, Coded)]
#[code(X001, error)]
#[error("invalid XML: {reason}")]
pub(crate) struct InvalidXml {
    pub reason: String,
    pub at: Span,
}

impl Finding for InvalidXml {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        diagnostic
            .label(self.at, "found here")
            .help("correct the file with the tool that wrote it")
    }
}
