use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};

/// Stray semicolon
///
/// AsmetaL has no separator. Put several rules into `par … endpar` to run them at once, or into `seq …
/// endseq` to run them one after the other.
///
/// ```asm wrong
/// asm example
/// import StandardLibrary
/// signature:
///   controlled a: Integer
///   controlled b: Integer
/// definitions:
///   main rule r_Main = par a := 1; b := 2; endpar
/// ```
///
/// Corrected:
///
/// ```asm corrected
/// asm example
/// import StandardLibrary
/// signature:
///   controlled a: Integer
///   controlled b: Integer
/// definitions:
///   main rule r_Main = par a := 1 b := 2 endpar
/// ```
#[derive(Debug, thiserror::Error, Coded)]
#[code(L010, error)]
#[error("unexpected `;`")]
pub(crate) struct StraySemicolon {
    pub at: Span,
}

impl Finding for StraySemicolon {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        diagnostic
            .label(self.at, "rules are not separated")
            .help("group several rules with `par … endpar` or `seq … endseq`")
            .fix("remove it, here and elsewhere", self.at, "")
    }
}
