use asmotion_composite::At;
use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span, did_you_mean};

/// Unknown name
///
/// The file refers to a component, a property of the composite, or a composite that does not exist.
///
/// ```xml wrong
/// <composite xmlns="http://docs.oasis-open.org/ns/opencsa/sca/200912" name="example">
///   <component name="Planner">
///     <implementation.java class="nav.Planner"/>
///     <reference name="maps" target="MapServr"/>
///   </component>
///   <component name="MapServer">
///     <implementation.java class="nav.MapServer"/>
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
///     <reference name="maps" target="MapServer"/>
///   </component>
///   <component name="MapServer">
///     <implementation.java class="nav.MapServer"/>
///   </component>
/// </composite>
/// ```
#[derive(Debug, thiserror::Error, Coded)]
#[code(X006, error)]
#[error("unknown {what} `{name}`")]
pub(crate) struct UnknownScdlName {
    pub what: &'static str,
    pub name: String,
    pub nearest: Option<At<String>>,
    pub at: Span,
}

impl Finding for UnknownScdlName {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        let Self { nearest, .. } = self;
        let error = diagnostic.label(self.at, "not declared");
        match nearest {
            Some(near) => error
                .label(near.span, "similar name declared here")
                .help(did_you_mean(&near.value)),
            None => error.help("declare it, or remove this"),
        }
    }
}
