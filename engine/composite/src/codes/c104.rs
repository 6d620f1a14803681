use crate::nearest::Nearest;
use crate::nearest::Suggest;
use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};

/// Service or reference not annotated
///
/// A specification that annotates references or services must annotate all of them, except those that
/// only the composite itself calls in `bind.out`.
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
/// references = { maps = { interface = "nav/Maps", optional = true }, plans = { interface = "nav/Plans", optional = true } }
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
#[code(C104, error)]
#[error("{what} `{name}` is not annotated in the specification")]
pub(crate) struct Unannotated {
    pub what: &'static str,
    pub name: String,
    pub at: Span,
    pub nearest: Option<Nearest>,
}

impl Finding for Unannotated {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        let Self { nearest, .. } = self;
        diagnostic
            .label(self.at, "not used by the specification")
            .help("remove it, or annotate it in the specification")
            .suggest(self.at, nearest)
    }
}
