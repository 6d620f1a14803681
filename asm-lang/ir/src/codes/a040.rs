use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span, did_you_mean, similar};
use std::sync::Arc;

/// Unknown operation
///
/// The operations of a partner are the out functions declared with the domain of the agent. There is
/// none of this name.
///
/// ```asm wrong
/// asm example
/// import StandardLibrary
/// import CommonBehavior
/// signature:
///   domain Planner subsetof Agent
///   static planner: Planner
///   out plan: Prod(Agent, Integer) -> Integer
/// definitions:
///   main rule r_Main = r_wsend[planner, "pln", 3]
/// ```
///
/// Corrected:
///
/// ```asm corrected
/// asm example
/// import StandardLibrary
/// import CommonBehavior
/// signature:
///   domain Planner subsetof Agent
///   static planner: Planner
///   out plan: Prod(Agent, Integer) -> Integer
/// definitions:
///   main rule r_Main = r_wsend[planner, "plan", 3]
/// ```
#[derive(Debug, thiserror::Error, Coded)]
#[code(A040, error)]
#[error("unknown operation `{name}` of `{domain}`")]
pub(crate) struct UnknownOperation {
    pub domain: Arc<str>,
    pub name: String,
    pub at: Span,
    pub declared: Span,
    /// Names of the operations declared for the domain, for suggestions.
    pub known: Vec<Arc<str>>,
}

impl Finding for UnknownOperation {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        let diagnostic = diagnostic.label(self.at, "not declared").label(
            self.declared,
            "operations are the out functions of this domain",
        );
        match similar(&self.name, &self.known) {
            Some(known) => diagnostic.help(did_you_mean(known)),
            None => {
                let known: Vec<String> =
                    self.known.iter().map(|name| format!("`{name}`")).collect();
                diagnostic.help(format!("the operations are {}", known.join(", ")))
            }
        }
    }
}
