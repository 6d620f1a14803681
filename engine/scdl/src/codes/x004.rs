use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};

/// No counterpart in a composite file
///
/// An element or an attribute that the dialect of this engine has no words for: nothing is dropped in silence, so it
/// stands as a comment in the composite file, above the thing it belongs to.
///
/// ```xml wrong
/// <composite xmlns="http://docs.oasis-open.org/ns/opencsa/sca/200912" name="example">
///   <component name="Planner" requires="confidentiality">
///     <implementation.java class="nav.Planner"/>
///   </component>
/// </composite>
/// ```
///
/// Mended:
///
/// ```xml mended
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
            .help("say it by hand where the comment stands, or leave it out")
    }
}
