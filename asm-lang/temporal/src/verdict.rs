//! Results of checks.

use crate::lasso::Lasso;

/// The result of a check.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct TemporalVerdict {
    /// A path that violates the formula, unless the formula holds.
    pub violation: Option<Lasso>,
    /// The initial nodes from which fair paths start. A formula of which nothing is fair holds, but says nothing.
    pub fair: FairPaths,
}

/// The initial nodes from which fair paths start. Other initial nodes do not count.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FairPaths {
    /// From every initial node.
    FromAll,
    /// From some initial nodes, but not from all.
    FromSome,
    /// From no initial node: every formula holds.
    FromNone,
}

impl TemporalVerdict {
    /// Returns whether the formula holds on all fair paths from initial nodes.
    pub fn holds(&self) -> bool {
        self.violation.is_none()
    }
}
