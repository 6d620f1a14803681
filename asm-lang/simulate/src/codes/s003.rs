use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span, did_you_mean};
use std::sync::Arc;

/// Unknown input
///
/// A script can set only monitored and shared functions of the specification.
///
/// ```asm
/// asm example
/// import StandardLibrary
/// signature:
///   enum domain Mode = {IDLE | BUSY}
///   monitored mode: Mode
///   monitored speed: Integer
///   controlled n: Integer
/// definitions:
///   main rule r_Main = if mode = BUSY then n := speed endif
/// ```
///
/// ```toml wrong
/// [default]
/// sped = 3
/// ```
///
/// Corrected:
///
/// ```toml corrected
/// [default]
/// speed = 3
/// ```
#[derive(Debug, thiserror::Error, Coded)]
#[code(S003, error)]
#[error("unknown input `{name}`")]
pub(crate) struct UnknownInput {
    pub name: String,
    pub at: Span,
    pub similar: Option<Arc<str>>,
}

impl Finding for UnknownInput {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        let diagnostic = diagnostic.label(
            self.at,
            "not a monitored or shared function with this number of arguments",
        );
        match &self.similar {
            Some(known) => diagnostic.help(did_you_mean(known)),
            None => diagnostic.help("only monitored and shared functions can be set"),
        }
    }
}
