use crate::nearest::Nearest;
use crate::nearest::Suggest;
use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};

/// Unknown implementation
///
/// The name is not in this build but resembles one that is, so it is probably misspelt.
///
/// ```toml wrong
/// schema = "composite/1"
///
/// [composite]
/// name = "example"
///
/// [components.Map]
/// implementation = { rust = "nav::MapServr" }
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
/// [components.Map]
/// implementation = { rust = "nav::MapServer" }
/// ```
#[derive(Debug, thiserror::Error, Coded)]
#[code(C024, error)]
#[error("unknown {what} `{name}`")]
pub(crate) struct UnknownImplementation {
    pub what: &'static str,
    pub name: String,
    pub at: Span,
    pub nearest: Option<Nearest>,
}

impl Finding for UnknownImplementation {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        let Self { nearest, .. } = self;
        diagnostic
            .label(self.at, "not in this build")
            .suggest(self.at, nearest)
    }
}
