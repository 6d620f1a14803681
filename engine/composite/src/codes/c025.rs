use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};

/// Implementation not in this build
///
/// The ports and services of the component cannot be verified, because this build does not contain it.
/// The composite can be checked with what it lists about the component, but not started by this build.
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
/// implementation = { process = "welding-gun" }
/// ```
///
/// A component that runs as a program of its own (`process`) does not have to be in the build.
#[derive(Debug, thiserror::Error, Coded)]
#[code(C025, warning)]
#[error("{what} `{name}` is not in this build")]
pub(crate) struct ImplementationNotInBuild {
    pub what: &'static str,
    pub name: String,
    pub at: Span,
}

impl Finding for ImplementationNotInBuild {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        diagnostic
            .label(self.at, "not verified by this build")
            .note("this build can check the composite, but not start it")
    }
}
