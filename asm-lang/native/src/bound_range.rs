//! Variables with their ranges, and how their bindings are counted.

use crate::static_analysis::StaticRange;
use asmotion_ir::{Local, Origin};

/// A variable, its range, and the place of the range.
pub(crate) type BoundRange = (Local, StaticRange, Origin);

/// The way in which the bindings of a loop are counted against the limit.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(crate) enum Counting {
    /// All before the loop, which runs to its end; leaves for the detour if the limit could be
    /// exceeded.
    Together,
    /// Like `Together`, but the limit has already been checked.
    Checked,
    /// One by one, in a rule; exceeding the limit is a fault.
    EachInRule,
    /// Not at all: the bindings of a direct rule are counted at compile time.
    Bounded,
    /// One by one, in a term; exceeding the limit is left to the detour.
    EachInTerm,
    /// One by one, in a rule, those that satisfy the equation that an index answers.
    Satisfying,
}

/// Returns the number of bindings made by loops over these variables.
pub(crate) fn total(spans: &[BoundRange]) -> u64 {
    spans.iter().rev().fold(0u64, |inner, (_, span, _)| {
        span.count().saturating_mul(inner.saturating_add(1))
    })
}
