use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};

/// Too many calls
///
/// A step may call functions and rules 10,000,000 times. A function that calls itself twice doubles
/// the number of calls with every level: 30 levels make 10⁹ calls.
///
/// ```asm wrong
/// asm example
/// import StandardLibrary
/// signature:
///   controlled n: Integer
///   static paths: Integer -> Integer
/// definitions:
///   function paths($x in Integer) = if $x = 0 then 1 else paths($x - 1) + paths($x - 1) endif
///   main rule r_Main = n := paths(60)
/// ```
///
/// Corrected:
///
/// ```asm corrected
/// asm example
/// import StandardLibrary
/// signature:
///   controlled n: Integer
///   static paths: Integer -> Integer
/// definitions:
///   function paths($x in Integer) = if $x = 0 then 1 else 2 * paths($x - 1) endif
///   main rule r_Main = n := paths(60)
/// ```
#[derive(Debug, thiserror::Error, Coded)]
#[code(R021, error)]
#[error("more than {limit} calls of functions and rules {when}")]
pub(crate) struct TooManyCalls {
    pub limit: u32,
    pub when: String,
    pub at: Span,
}

impl Finding for TooManyCalls {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        diagnostic
            .label(self.at, "limit exceeded here")
            .help("store intermediate results in a location instead of computing them again")
    }
}
