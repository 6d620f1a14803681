use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};

/// Too many errors
///
/// Checking stops after 50 errors, because most further errors would follow from earlier ones. Fix the
/// first errors and check again.
///
/// ```asm wrong
/// asm example
/// signature:
/// definitions:
///   rule s0 = skip
///   rule s1 = skip
///   rule s2 = skip
///   rule s3 = skip
///   rule s4 = skip
///   rule s5 = skip
///   rule s6 = skip
///   rule s7 = skip
///   rule s8 = skip
///   rule s9 = skip
///   rule s10 = skip
///   rule s11 = skip
///   rule s12 = skip
///   rule s13 = skip
///   rule s14 = skip
///   rule s15 = skip
///   rule s16 = skip
///   rule s17 = skip
///   rule s18 = skip
///   rule s19 = skip
///   rule s20 = skip
///   rule s21 = skip
///   rule s22 = skip
///   rule s23 = skip
///   rule s24 = skip
///   rule s25 = skip
///   rule s26 = skip
///   rule s27 = skip
///   rule s28 = skip
///   rule s29 = skip
///   rule s30 = skip
///   rule s31 = skip
///   rule s32 = skip
///   rule s33 = skip
///   rule s34 = skip
///   rule s35 = skip
///   rule s36 = skip
///   rule s37 = skip
///   rule s38 = skip
///   rule s39 = skip
///   rule s40 = skip
///   rule s41 = skip
///   rule s42 = skip
///   rule s43 = skip
///   rule s44 = skip
///   rule s45 = skip
///   rule s46 = skip
///   rule s47 = skip
///   rule s48 = skip
///   rule s49 = skip
///   rule s50 = skip
///   rule s51 = skip
///   rule s52 = skip
///   rule s53 = skip
///   rule s54 = skip
///   rule s55 = skip
///   rule s56 = skip
///   rule s57 = skip
///   rule s58 = skip
///   rule s59 = skip
///   main rule r_Main = skip
/// ```
///
/// Corrected:
///
/// ```asm corrected
/// asm example
/// import StandardLibrary
/// signature:
/// definitions:
///   main rule r_Main = skip
/// ```
#[derive(Debug, thiserror::Error, Coded)]
#[code(L062, error)]
#[error("too many errors")]
pub(crate) struct TooManyErrors {
    pub at: Span,
}

impl Finding for TooManyErrors {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        diagnostic.label(self.at, "the rest of the file is not checked")
    }
}
