use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};

/// Calls nested too deep
///
/// A function or turbo rule calls itself without end.
///
/// ```asm wrong
/// asm example
/// import StandardLibrary
/// signature:
///   controlled n: Integer
///   static down: Integer -> Integer
/// definitions:
///   function down($x in Integer) = down($x + 1)
///   main rule r_Main = n := down(0)
/// ```
///
/// Corrected:
///
/// ```asm corrected
/// asm example
/// import StandardLibrary
/// signature:
///   controlled n: Integer
///   static down: Integer -> Integer
/// definitions:
///   function down($x in Integer) = if $x >= 9 then $x else down($x + 1) endif
///   main rule r_Main = n := down(0)
/// ```
#[derive(Debug, thiserror::Error, Coded)]
#[code(R010, error)]
#[error("calls nested deeper than {limit} {when}")]
pub(crate) struct CallsTooDeep {
    pub limit: u32,
    pub when: String,
    pub at: Span,
}

impl Finding for CallsTooDeep {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        diagnostic
            .label(self.at, "limit exceeded here")
            .help("check that the recursion ends for every argument")
    }
}
