use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};
use std::sync::Arc;

/// Wrong number of arguments
///
/// A rule or function takes one argument for each of its parameters.
///
/// ```asm wrong
/// asm example
/// import StandardLibrary
/// signature:
///   controlled n: Integer
/// definitions:
///   rule r_set($x in Integer) = n := $x
///   main rule r_Main = r_set[1, 2]
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
///   rule r_set($x in Integer) = n := $x
///   main rule r_Main = r_set[1]
/// ```
#[derive(Debug, thiserror::Error, Coded)]
#[code(A008, error)]
#[error("`{name}` takes {expected} argument{}, not {actual}", if *expected == 1 { "" } else { "s" })]
pub(crate) struct WrongArity {
    pub name: Arc<str>,
    pub expected: usize,
    pub actual: usize,
    pub at: Span,
    pub declared: Span,
}

impl Finding for WrongArity {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        let Self { actual, .. } = self;
        diagnostic
            .label(self.at, format!("{actual} given"))
            .label(self.declared, "declared here")
            .help("pass one argument for each parameter")
    }
}
