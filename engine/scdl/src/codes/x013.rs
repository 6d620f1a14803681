use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};

/// Several promotions in one
///
/// In SCDL, one reference of a composite can promote the references of several components. In a
/// composite file each promotion promotes one thing, so the others get names of their own.
///
/// ```xml wrong
/// <composite xmlns="http://docs.oasis-open.org/ns/opencsa/sca/200912" name="example">
///   <component name="Planner">
///     <implementation.java class="nav.Planner"/>
///     <reference name="maps"><interface.java interface="nav.MapService"/></reference>
///   </component>
///   <component name="Guide">
///     <implementation.java class="nav.Guide"/>
///     <reference name="maps"><interface.java interface="nav.MapService"/></reference>
///   </component>
///   <reference name="maps" promote="Planner/maps Guide/maps"/>
/// </composite>
/// ```
///
/// Corrected:
///
/// ```xml corrected
/// <composite xmlns="http://docs.oasis-open.org/ns/opencsa/sca/200912" name="example">
///   <component name="Planner">
///     <implementation.java class="nav.Planner"/>
///     <reference name="maps"><interface.java interface="nav.MapService"/></reference>
///   </component>
///   <component name="Guide">
///     <implementation.java class="nav.Guide"/>
///     <reference name="maps"><interface.java interface="nav.MapService"/></reference>
///   </component>
///   <reference name="maps" promote="Planner/maps"/>
///   <reference name="more" promote="Guide/maps"/>
/// </composite>
/// ```
#[derive(Debug, thiserror::Error, Coded)]
#[code(X013, warning)]
#[error("several promotions in `{of}`")]
pub(crate) struct SeveralPromoted {
    pub of: String,
    pub promoted: String,
    pub name: String,
    pub at: Span,
}

impl Finding for SeveralPromoted {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        let Self { promoted, name, .. } = self;
        diagnostic
            .label(self.at, format!("`{promoted}` becomes `{name}`"))
            .help("write one promotion for each, and wire each by its own name")
    }
}
