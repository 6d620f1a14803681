use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};

/// Wrong main rule
///
/// The specification declares its main rule; `main` in the composite only repeats its name, and the two
/// differ.
///
/// ```asm
/// asm example
/// signature:
/// definitions:
///   main rule r_Main = skip
/// ```
///
/// ```toml wrong
/// schema = "composite/1"
///
/// [composite]
/// name = "example"
///
/// [components.Coordinator]
/// implementation = { asm = "example.asm", main = "r_Mian" }
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
/// [components.Coordinator]
/// implementation = { asm = "example.asm", main = "r_Main" }
/// ```
#[derive(Debug, thiserror::Error, Coded)]
#[code(C101, error)]
#[error("`{name}` is not the main rule of the specification")]
pub(crate) struct OtherMainRule {
    pub name: String,
    pub at: Span,
    pub found: Option<(String, Span)>,
}

impl Finding for OtherMainRule {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        let Self { found, .. } = self;
        let diagnostic = diagnostic.label(self.at, "named here");
        match found {
            Some((name, declared)) => diagnostic
                .label(*declared, "main rule declared here")
                .did_you_mean(self.at, Some(name)),
            None => diagnostic.note("the specification is a module without a main rule"),
        }
    }
}
