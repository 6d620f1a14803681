//! Detours: the closures that native code leaves work to.

use asmotion_machine::back_end::{RuleCode, TermCode, TruthCode};

/// A closure that does the work of a node again from its beginning.
pub(crate) enum Detour {
    Rule(RuleCode),
    Truth(TruthCode),
    Term(TermCode),
}
