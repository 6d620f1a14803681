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

/// The way in which the value of a variable of `choose` is determined.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Choosing {
    /// The chooser selects a candidate by its index.
    ByNumber,
    /// The first candidate is taken, and no choice is recorded.
    First,
    /// The value was picked from outside.
    Picked,
}

impl Choosing {
    /// Asks a chooser how it chooses the value of a variable with this range.
    #[inline]
    pub(crate) fn by(chooser: &dyn Chooser, range: Origin) -> Self {
        match chooser.picked(range) {
            Some(_) => Self::Picked,
            None if chooser.takes_first() => Self::First,
            None => Self::ByNumber,
        }
    }
}
