//! Interval analysis of integers: the least and the greatest value known at compile time.

use crate::code::Arithmetic;

/// An interval of integers, both bounds included.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct IntegerInterval {
    /// Least possible value.
    pub low: i64,
    /// Greatest possible value, at least `low`.
    pub high: i64,
}

impl IntegerInterval {
    /// All 64-bit integers: the value is unknown.
    pub const ANY: Self = Self {
        low: i64::MIN,
        high: i64::MAX,
    };

    /// The interval of a single number.
    pub fn of(number: i64) -> Self {
        Self {
            low: number,
            high: number,
        }
    }

    /// Returns `true` if the interval lies within these bounds.
    pub fn within(self, low: i64, high: i64) -> bool {
        low <= self.low && self.high <= high
    }

    /// Returns the smallest interval that contains both.
    pub fn or(self, other: Self) -> Self {
        Self {
            low: self.low.min(other.low),
            high: self.high.max(other.high),
        }
    }

    /// Returns the interval of an operation's results, and `true` if some may exceed 64 bits.
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
                // the result has the dividend's sign, and its magnitude is less than the divisor's
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
