use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};

/// Interface differs from the annotation
///
/// The domain of the partner under `//@Reference` has the name of the interface. The composite lists
/// another one.
///
/// ```asm
/// asm example
/// import StandardLibrary
/// import CommonBehavior
/// signature:
///   domain Maps subsetof Agent
///   //@Reference
///   shared maps: Agent -> Maps
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
/// [components.Guide]
/// implementation = { asm = "example.asm" }
/// references = { maps = { interface = "nav/Plans", optional = true } }
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
/// [components.Guide]
/// implementation = { asm = "example.asm" }
/// references = { maps = { interface = "nav/Maps", optional = true } }
/// ```
#[derive(Debug, thiserror::Error, Coded)]
#[code(C103, error)]
#[error("{what} `{name}` is annotated as `{annotated}`, but listed as `{listed}`")]
pub(crate) struct OtherInterface {
    pub what: &'static str,
    pub name: String,
    pub annotated: String,
    pub listed: String,
    pub at: Span,
    pub declared: Span,
}

impl Finding for OtherInterface {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        let Self { annotated, .. } = self;
        diagnostic
            .label(self.at, "listed here")
            .label(self.declared, "annotated here")
            .help(format!("end the interface with `{annotated}`"))
    }
}
