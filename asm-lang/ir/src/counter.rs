//! Coverage counters of a program.

use crate::id::Origin;

/// A part of a program with a coverage counter.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Counted {
    /// Place of the construct in the sources.
    pub origin: Origin,
    /// The part of the construct.
    pub part: CoveragePoint,
}

/// The kinds of program parts that coverage counts.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum CoveragePoint {
    /// A declared rule; its origin is its name.
    Rule,
    /// An update.
    Update,
    /// `then`
    Then,
    /// `else`, written or implicit.
    Else,
    /// The case with this index, from 0.
    Case(u32),
    /// `otherwise`, written or implicit.
    Otherwise,
    /// A `choose` with at least one candidate.
    Found,
    /// A `choose` without candidates.
    NotFound,
    /// One iteration of a `forall`.
    Round,
    /// A `forall` without iterations.
    None,
    /// A `forall` with exactly one iteration.
    One,
    /// A `forall` with several iterations.
    Many,
}

/// The counters that a rule increments.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Counter {
    /// Increments the counter with this index.
    Count(u32),
    /// Increments one of three counters, depending on how often the counter of iterations was
    /// incremented while the rule ran.
    Rounds {
        /// Index of the counter of iterations.
        round: u32,
        /// Index of the counter for no iteration; those for one and for several follow it.
        none: u32,
    },
}
