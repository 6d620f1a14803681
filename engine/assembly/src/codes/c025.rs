use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};

/// An implementation that is not in this build
///
/// What this build does not have is believed, so that the composite can be checked; it cannot be started here.
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
/// Mended:
///
/// ```toml mended
/// schema = "composite/1"
///
/// [composite]
/// name = "example"
///
/// [components.Arm]
/// implementation = { process = "welding-gun" }
/// ```
///
/// A program of its own is no component of the build.
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
            .label(self.at, "what the composite says of it is believed")
            .note("the composite can be checked, but not started here")
    }
}
