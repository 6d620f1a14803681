use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};

/// Password in the file
///
/// A password in the file is visible to everyone who can read it. The generated composite file refers
/// to an environment variable instead, and so does SCDL that is exported from it.
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
/// Corrected:
///
/// ```xml corrected
/// <composite xmlns="http://docs.oasis-open.org/ns/opencsa/sca/200912" name="example">
///   <component name="Store">
///     <implementation.java class="nav.Store"/>
///     <property name="password">${STORE_PASSWORD}</property>
///   </component>
/// </composite>
/// ```
#[derive(Debug, thiserror::Error, Coded)]
#[code(X005, warning)]
#[error("password of `{of}` in the file")]
pub(crate) struct PasswordInScdl {
    pub of: String,
    pub variable: String,
    pub at: Span,
}

impl Finding for PasswordInScdl {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        let Self { variable, .. } = self;
        diagnostic
            .label(self.at, "visible to everyone who can read the file")
            .help(format!(
                "set `{variable}`; the composite file refers to it instead"
            ))
    }
}
