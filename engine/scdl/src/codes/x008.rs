use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};

/// Assumed value
///
/// In SCDL, some facts are defined only in the Java class. A fact that neither the file nor a component
/// of this build defines is assumed.
///
/// ```xml wrong
/// <composite xmlns="http://docs.oasis-open.org/ns/opencsa/sca/200912" name="example">
///   <component name="Planner">
///     <implementation.java class="nav.Planner"/>
///     <reference name="maps" target="MapServer"/>
///   </component>
///   <component name="MapServer">
///     <implementation.java class="nav.Server"/>
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
///     <reference name="maps" target="MapServer">
///       <interface.java interface="nav.MapService"/>
///     </reference>
///   </component>
///   <component name="MapServer">
///     <implementation.java class="nav.Server"/>
///   </component>
/// </composite>
/// ```
#[derive(Debug, thiserror::Error, Coded)]
#[code(X008, warning)]
#[error("`{of}` does not specify {what}")]
pub(crate) struct AssumedValue {
    pub what: &'static str,
    pub of: String,
    pub assumed: String,
    pub at: Span,
}

impl Finding for AssumedValue {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        let Self { assumed, .. } = self;
        diagnostic
            .label(self.at, format!("assuming `{assumed}`"))
            .help("correct it in the composite file")
    }
}
