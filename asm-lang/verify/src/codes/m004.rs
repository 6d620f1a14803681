use asmotion_diagnostics::{Coded, Diagnostic, Finding};

/// Property that is too large
///
/// A formula of LTL is turned into an automaton, whose size grows exponentially with the number of temporal operators. A property
/// with dozens of nested operators can exceed the limit, as does `exN` or `axN` over more than 65536 steps.
///
/// ```text wrong
/// CTLSPEC exN(isOn, 4000000000n)
/// ```
///
/// Several properties with fewer operators each say the same.
#[derive(Debug, thiserror::Error, Coded)]
#[code(M004, error)]
#[error("a property cannot be checked: {reason}")]
pub(crate) struct FormulaTooLarge {
    pub reason: String,
}

impl Finding for FormulaTooLarge {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        diagnostic.help("split it into several properties")
    }
}
