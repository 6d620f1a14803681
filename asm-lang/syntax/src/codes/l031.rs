use crate::edits::SpannedText;
use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};

/// Unclosed block or bracket
///
/// Every `par`, `seq`, `if`, `let`, `switch` and bracket needs its own end. The end found here belongs
/// to an outer block.
///
/// ```asm wrong
/// asm example
/// import StandardLibrary
/// signature:
///   controlled n: Integer
/// definitions:
///   main rule r_Main =
///     par
///       if true then
///         n := 1
///       skip
///     endpar
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
///   main rule r_Main =
///     par
///       if true then
///         n := 1
///       endif
///       skip
///     endpar
/// ```
#[derive(Debug, thiserror::Error, Coded)]
#[code(L031, error)]
#[error("missing `{missing}` to close `{}`", open.0)]
pub(crate) struct UnclosedBlock {
    pub missing: String,
    pub at: Span,
    pub open: SpannedText,
    pub misaligned: Option<(SpannedText, SpannedText)>,
}

impl Finding for UnclosedBlock {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        let Self {
            missing,
            misaligned,
            ..
        } = self;
        let unclosed = diagnostic
            .label(self.at, format!("expected `{missing}` before this"))
            .label(self.open.1, "opened here");
        match misaligned {
            Some((inner, end)) => unclosed
                .label(
                    inner.1,
                    format!("this `{}` may be the unclosed one", inner.0),
                )
                .label(
                    end.1,
                    format!("this `{}` closes it at a different indentation", end.0),
                ),
            None => unclosed,
        }
    }
}
