use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};

/// Inconsistent update
///
/// A step applies all updates at once, so a location can get only one value. Two rules write different
/// values to the same location: there is no next state, and the machine stays in the current one. The
/// message shows both rules, both values, and what the surrounding rules read.
///
/// ```asm wrong
/// asm example
/// import StandardLibrary
/// signature:
///   controlled n: Integer
/// definitions:
///   main rule r_Main = par n := 1 n := 2 endpar
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
///   main rule r_Main = seq n := 1 n := 2 endseq
/// ```
///
/// With `seq`, one rule runs after the other and the later one wins. With `if … else …`, only one of
/// them runs.
#[derive(Debug, thiserror::Error, Coded)]
#[code(R001, error)]
#[error("inconsistent update of `{location}` {when}")]
pub(crate) struct Clash {
    pub location: String,
    pub when: String,
    pub at: Span,
    pub value: String,
    /// Place of the rule that wrote first.
    pub first_at: Span,
    pub first: String,
}

impl Finding for Clash {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        diagnostic
            .label(self.at, format!("writes {}", self.value))
            .label(self.first_at, format!("writes {} in the same step", self.first))
            .note("a step applies all its updates at once, so each location gets one value; the state is unchanged")
            .help("move one of them into the `else` of the other, or both into `seq … endseq` if the later one should win")
    }
}
