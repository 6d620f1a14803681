use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};

/// Annotation not listed in the composite
///
/// The annotations `//@Reference`, `//@MainService` and `//@Provided` declare what a specification
/// requires and provides. The composite must list each of them, or it stays unconnected.
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
#[code(C102, error)]
#[error("{what} `{name}` of the specification is not listed in the composite")]
pub(crate) struct UnlistedAnnotation {
    pub what: &'static str,
    pub name: String,
    pub interface: String,
    pub at: Span,
    pub declared: Span,
}

impl Finding for UnlistedAnnotation {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        let Self {
            what,
            name,
            interface,
            ..
        } = self;
        diagnostic
            .label(self.at, "not listed here")
            .label(self.declared, "annotated here")
            .help(format!("add `{what}s = {{ {name} = \"…/{interface}\" }}`"))
    }
}
