use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};

/// A password in the file
///
/// Whoever has the file has the password. The composite file names a variable of the environment in its place, and so
/// does the SCDL that is exported from it.
///
/// ```xml wrong
/// <composite xmlns="http://docs.oasis-open.org/ns/opencsa/sca/200912" name="example">
///   <component name="Store">
///     <implementation.java class="nav.Store"/>
///     <property name="password">secret</property>
///   </component>
/// </composite>
/// ```
///
/// Mended:
///
/// ```xml mended
/// <composite xmlns="http://docs.oasis-open.org/ns/opencsa/sca/200912" name="example">
///   <component name="Store">
///     <implementation.java class="nav.Store"/>
///     <property name="password">${STORE_PASSWORD}</property>
///   </component>
/// </composite>
/// ```
#[derive(Debug, thiserror::Error, Coded)]
#[code(X005, warning)]
#[error("the password of `{of}` stands in the file")]
pub(crate) struct PasswordInScdl {
    pub of: String,
    pub variable: String,
    pub at: Span,
}

impl Finding for PasswordInScdl {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        let Self { variable, .. } = self;
        diagnostic
            .label(self.at, "whoever has the file has it")
            .help(format!(
                "set `{variable}`, which the composite file names in its place"
            ))
    }
}
