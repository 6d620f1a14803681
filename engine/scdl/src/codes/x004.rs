use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};

/// No counterpart in a composite file
///
/// The composite dialect cannot express this element or attribute. It is kept as a comment above the
/// thing it belongs to, so that nothing is lost silently.
///
/// ```xml wrong
/// <composite xmlns="http://docs.oasis-open.org/ns/opencsa/sca/200912" name="example">
///   <component name="Planner" requires="confidentiality">
///     <implementation.java class="nav.Planner"/>
///   </component>
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
#[code(X004, warning)]
#[error("`{what}` has no counterpart in a composite file")]
pub(crate) struct NoCounterpart {
    pub what: String,
    pub at: Span,
}

impl Finding for NoCounterpart {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        diagnostic
            .label(self.at, "kept as a comment")
            .help("replace the comment by hand, or remove it")
    }
}
