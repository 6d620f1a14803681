//! The source of non-deterministic choices.

use asmotion_ir::Origin;
use asmotion_value::Value;

/// Decides `choose` rules and `chooseone` terms. Equal decisions give equal runs.
pub trait Chooser {
    /// Returns the index of the chosen candidate. Candidates are in ascending order of their
    /// values, and `count`, their number, is at least 1. An index beyond the last candidate selects
    /// the last.
    fn choose(&mut self, count: usize) -> usize;

    /// Returns `true` if the first candidate is always taken. In this case candidates are not
    /// counted and no choice is recorded.
    fn takes_first(&self) -> bool {
        false
    }

    /// Returns a value picked for a variable of a `choose`, identified by the place of its range.
    /// It must be one of the candidates. `None` leaves the choice to [`Chooser::choose`].
    fn picked(&self, _range: Origin) -> Option<Value> {
        None
    }
}

/// Always takes the first candidate, which makes runs deterministic.
#[derive(Clone, Copy, Debug, Default)]
pub struct FirstChoice;

impl Chooser for FirstChoice {
    fn choose(&mut self, _count: usize) -> usize {
        0
    }

    fn takes_first(&self) -> bool {
        true
    }
}
