//! What is known about an integer before the program runs: least and greatest value.

use crate::code::Arithmetic;

/// Bounds, both included.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct IntegerInterval {
    /// The least.
    pub low: i64,
    /// The greatest.
    pub high: i64,
}

impl IntegerInterval {
    /// Nothing is known.
    pub const ANY: Self = Self {
        low: i64::MIN,
        high: i64::MAX,
    };

    /// One number.
    pub fn of(number: i64) -> Self {
        Self {
            low: number,
            high: number,
        }
    }

    /// Whether all of it lies within these bounds.
    pub fn within(self, low: i64, high: i64) -> bool {
        low <= self.low && self.high <= high
    }

    /// The least interval that holds both.
    pub fn or(self, other: Self) -> Self {
        Self {
            low: self.low.min(other.low),
            high: self.high.max(other.high),
        }
    }

    /// The results of an operation, and whether some may lie beyond 64 bits.
    pub fn computed(operation: Arithmetic, left: Self, right: Self) -> (Self, bool) {
        let [a, b, c, d] = [left.low, left.high, right.low, right.high].map(i128::from);
        let (low, high) = match operation {
            Arithmetic::Plus => (a + c, b + d),
            Arithmetic::Minus => (a - d, b - c),
            Arithmetic::Mult => {
                let corners = [a * c, a * d, b * c, b * d];
                let low = corners.iter().copied().fold(i128::MAX, i128::min);
                let high = corners.iter().copied().fold(i128::MIN, i128::max);
                (low, high)
            }
            Arithmetic::Mod => {
                // the sign is the dividend's, the size below the divisor's
                let most = (c.abs().max(d.abs()) - 1).max(0);
                let low = if a >= 0 { 0 } else { -most.min(-a) };
                let high = if b <= 0 { 0 } else { most.min(b) };
                (low, high)
            }
        };
        let bound = |number: i128| number.clamp(i64::MIN.into(), i64::MAX.into()) as i64;
        let bounded = Self {
            low: bound(low),
            high: bound(high),
        };
        let overflows = i128::from(bounded.low) != low || i128::from(bounded.high) != high;
        (bounded, overflows)
    }
}
