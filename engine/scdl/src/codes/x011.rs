use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};

/// Name not allowed in a composite file
///
/// An XML name may contain dots. In a composite file, a dot separates a component from its port.
///
/// ```xml wrong
/// <composite xmlns="http://docs.oasis-open.org/ns/opencsa/sca/200912" name="example">
///   <component name="nav.Planner">
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
#[code(X011, warning)]
#[error("`{name}` is not a valid name in a composite file")]
pub(crate) struct RenamedForToml {
    pub name: String,
    pub renamed: String,
    pub at: Span,
}

impl Finding for RenamedForToml {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        let Self { renamed, .. } = self;
        diagnostic
            .label(self.at, format!("renamed to `{renamed}`"))
            .help("use letters, digits, `_` and `-`, starting with a letter")
    }
}
