use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};

/// Missing attribute
///
/// The attribute is required: without it the element has no meaning.
///
/// ```xml wrong
/// <composite xmlns="http://docs.oasis-open.org/ns/opencsa/sca/200912" name="example">
///   <component name="Planner">
///     <implementation.java/>
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
#[code(X003, error)]
#[error("missing attribute `{attribute}` of `<{element}>`")]
pub(crate) struct MissingAttribute {
    pub element: String,
    pub attribute: &'static str,
    pub at: Span,
}

impl Finding for MissingAttribute {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        let Self { attribute, .. } = self;
        diagnostic
            .label(self.at, "element without the attribute")
            .help(format!("add `{attribute}=\"…\"`"))
    }
}
