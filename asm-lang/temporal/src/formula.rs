//! Common operations on formulas of both logics.

/// A formula of CTL or LTL.
pub(crate) trait Formula: Sized {
    /// Returns the formula that holds everywhere, or nowhere.
    fn constant(value: bool) -> Self;

    /// Returns the index of the atom that the formula is.
    fn as_atom(&self) -> Option<usize>;

    /// Returns what the formula implies something from.
    fn antecedent(&self) -> Option<&Self>;

    /// Returns the formula that a path violates if it contains a position, or reaches a node, where `self` holds.
    fn never(self) -> Self;

    /// Returns the formula with each operand replaced, from left to right.
    fn with_operands(&self, replace: &mut dyn FnMut(&Self, Polarity) -> Self) -> Self;
}

/// The effect of an operand on a formula.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Polarity {
    /// A weaker operand makes the formula weaker, or does not change it.
    Positive,
    /// A weaker operand makes the formula stronger, or does not change it.
    Negative,
    /// Either.
    Mixed,
}

impl Polarity {
    /// Returns the effect of an operand of an operand.
    pub(crate) fn of(self, inner: Self) -> Self {
        match (self, inner) {
            (Self::Mixed, _) | (_, Self::Mixed) => Self::Mixed,
            (Self::Positive, inner) => inner,
            (Self::Negative, Self::Positive) => Self::Negative,
            (Self::Negative, Self::Negative) => Self::Positive,
        }
    }
}
