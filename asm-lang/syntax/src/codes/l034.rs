use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};

/// Several rules instead of one
///
/// A rule declaration, a branch and the body of `do` contain one rule. Use `par … endpar` to run
/// several at once, or `seq … endseq` to run them one after the other.
///
/// ```asm wrong
/// asm example
/// import StandardLibrary
/// signature:
///   controlled a: Integer
///   controlled b: Integer
/// definitions:
///   main rule r_Main = if true then a := 1 b := 2 endif
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
///   main rule r_Main = if true then par a := 1 b := 2 endpar endif
/// ```
#[derive(Debug, thiserror::Error, Coded)]
#[code(L034, error)]
#[error("expected one rule, found several")]
pub(crate) struct SeveralRules {
    pub first: Span,
    pub second: Span,
    pub all: Option<(Span, String)>,
}

impl Finding for SeveralRules {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        let Self { all, .. } = self;
        let found = diagnostic.label(self.second, "second rule");
        let found = match all {
            Some(_) => found.label(self.first, "first rule"),
            None => found.label(self.first, "takes one rule"),
        };
        let found = found.help("group them with `par … endpar` or `seq … endseq`");
        match all {
            Some((span, text)) => {
                found.guess("run them in parallel", *span, format!("par {text} endpar"))
            }
            None => found,
        }
    }
}
