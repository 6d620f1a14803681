use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};

/// Implementation not in this build
///
/// The ports and services of the component cannot be verified, because this build does not contain it.
/// The composite can be checked with what it lists about the component, but not started by this build.
/// This also holds for a program of its own (`process`, `ros`, `orocos`): start it yourself, in a process that the
/// composite does not start.
///
/// ```toml wrong
/// schema = "composite/1"
///
/// [composite]
/// name = "example"
///
/// [components.Arm]
/// implementation = { rust = "acme::WeldingGun" }
/// ```
///
/// Corrected:
///
/// ```toml corrected
/// schema = "composite/1"
///
/// [composite]
/// name = "example"
///
/// [components.Arm]
/// implementation = { rust = "youbot::DummyDriver" }
/// ```
#[derive(Debug, thiserror::Error, Coded)]
#[code(C025, warning)]
#[error("{what} `{name}` is not in this build")]
pub(crate) struct ImplementationNotInBuild {
    pub what: &'static str,
    pub name: String,
    pub at: Span,
    /// Way out without it.
    pub instead: Option<String>,
}

impl Finding for ImplementationNotInBuild {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        let diagnostic = diagnostic
            .label(self.at, "not verified by this build")
            .note("this build can check the composite, but not start it");
        match &self.instead {
            Some(instead) => diagnostic.help(instead.clone()),
            None => diagnostic,
        }
    }
}
