use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};
use std::sync::Arc;

/// Macro that grows without end
///
/// The parameters of a macro stand for the terms it is called with. A macro that calls itself with a
/// larger term each time cannot be expanded. A turbo rule gets values instead.
///
/// ```asm wrong
/// asm example
/// import StandardLibrary
/// signature:
///   controlled n: Integer
/// definitions:
///   rule r_more($x in Integer) =
///     seq
///       n := 0
///       if $x < 9 then r_more[$x + n] endif
///       n := $x
///     endseq
///   main rule r_Main = r_more[n]
/// default init s0:
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
///   turbo rule r_more($x in Integer) =
///     seq
///       n := 0
///       if $x < 9 then r_more($x + 1) endif
///       n := $x
///     endseq
///   main rule r_Main = r_more(n)
/// default init s0:
///   function n = 0
/// ```
#[derive(Debug, thiserror::Error, Coded)]
#[code(A031, error)]
pub(crate) enum MacroGrows {
    #[error("`{rule}` calls itself with an argument that grows with every call")]
    Argument { rule: Arc<str>, declared: Span },
    #[error("an argument passed by name becomes too large")]
    Term { at: Span },
}

impl Finding for MacroGrows {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        let diagnostic = match self {
            Self::Argument { declared, .. } => {
                diagnostic.label(*declared, "the argument of this macro grows with each call")
            }
            Self::Term { at } => diagnostic.label(*at, "passed from macro to macro"),
        };
        diagnostic.help(
            "declare the macro as a `turbo rule`, which takes values, or bind the value with `let` before the call",
        )
    }
}
