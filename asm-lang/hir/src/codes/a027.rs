use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};

/// No default initial state
///
/// If there are several initial states, one of them must be the `default`: the machine starts in it.
///
/// ```asm wrong
/// asm example
/// import StandardLibrary
/// signature:
///   controlled n: Integer
/// definitions:
///   main rule r_Main = n := n + 1
/// init s0:
///   function n = 0
/// ```
///
/// Corrected:
///
/// ```asm corrected
/// asm example
/// import StandardLibrary
/// signature:
///   controlled n: Integer
/// definitions:
///   main rule r_Main = n := n + 1
/// default init s0:
///   function n = 0
/// ```
#[derive(Debug, thiserror::Error, Coded)]
#[code(A027, error)]
#[error("no initial state is {expected}")]
pub(crate) struct NoSuchInit {
    pub expected: String,
    pub at: Span,
    pub help: String,
}

impl Finding for NoSuchInit {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        let Self { help, .. } = self;
        diagnostic
            .label(self.at, "initial state declared here")
            .help(help)
    }
}
