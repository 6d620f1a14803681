use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span, did_you_mean};
use std::sync::Arc;

/// Unknown partner
///
/// A script plays agents that the specification declares. This one is not declared.
///
/// ```asm
/// asm example
/// import StandardLibrary
/// import CommonBehavior
/// signature:
///   domain Planner subsetof Agent
///   static planner: Planner
///   out plan: Prod(Agent, Integer) -> Integer
///   controlled length: Integer
/// definitions:
///   main rule r_Main = r_wcall[planner, "plan", 7, 2000, length]
/// ```
///
/// ```toml wrong
/// [partner.planer]
/// plan = { reply = 3 }
/// ```
///
/// Corrected:
///
/// ```toml corrected
/// [partner.planner]
/// plan = { reply = 3 }
/// ```
#[derive(Debug, thiserror::Error, Coded)]
#[code(S006, error)]
#[error("unknown agent `{name}`")]
pub(crate) struct UnknownPartner {
    pub name: String,
    pub at: Span,
    pub similar: Option<Arc<str>>,
}

impl Finding for UnknownPartner {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        let diagnostic = diagnostic.label(self.at, "not declared in the specification");
        match &self.similar {
            Some(known) => diagnostic.help(did_you_mean(known)),
            None => diagnostic.help("declare it, as in `static planner: Planner`"),
        }
    }
}
