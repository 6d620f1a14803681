//! Detours: the closures to which native code leaves work.

use asmotion_machine::back_end::{RuleCode, TermCode, TruthCode};

/// A closure that executes a node from its beginning.
pub(crate) enum Detour {
    Rule(RuleCode),
    Truth(TruthCode),
    Term(TermCode),
}
