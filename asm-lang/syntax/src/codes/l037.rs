use crate::edits::SpannedText;
use asmotion_diagnostics::{Coded, Diagnostic, Finding};

/// Call without brackets
///
/// A macro rule is called with square brackets, a turbo rule with round brackets, even without
/// arguments.
///
/// ```asm wrong
/// asm example
/// import StandardLibrary
/// signature:
///   controlled n: Integer
/// definitions:
///   rule r_set = n := 1
///   main rule r_Main = par r_set skip endpar
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
///   rule r_set = n := 1
///   main rule r_Main = par r_set[] skip endpar
/// ```
#[derive(Debug, thiserror::Error, Coded)]
#[code(L037, error)]
#[error("missing brackets in the call of `{}`", call.0)]
pub(crate) struct CallWithoutBrackets {
    pub call: SpannedText,
}

impl Finding for CallWithoutBrackets {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        let Self { call: (rule, at) } = self;
        diagnostic
            .label(*at, "expected `[` after this")
            .help("call a turbo rule with parentheses")
            .fix("add `[]`", *at, format!("{rule}[]"))
    }
}
