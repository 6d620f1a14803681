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
            Arithmetic::Mod if a == b && c == d && c != 0 => (a % c, a % c),
            // a divisor that is greater leaves the dividend as it is
            Arithmetic::Mod if a >= 0 && c > b => (a, b),
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

#[cfg(test)]
mod tests {
    use super::*;

    const OPERATIONS: [Arithmetic; 4] = [
        Arithmetic::Plus,
        Arithmetic::Minus,
        Arithmetic::Mult,
        Arithmetic::Mod,
    ];

    /// Returns the result of an operation on two integers; `None` if it exceeds 64 bits or does not exist.
    fn result(operation: Arithmetic, left: i64, right: i64) -> Option<i64> {
        match operation {
            Arithmetic::Plus => left.checked_add(right),
            Arithmetic::Minus => left.checked_sub(right),
            Arithmetic::Mult => left.checked_mul(right),
            // the least integer mod -1 is 0
            Arithmetic::Mod => (right != 0).then(|| left.wrapping_rem(right)),
        }
    }

    /// Returns all intervals between neighbouring or distant ones of these bounds.
    fn intervals(bounds: &[i64]) -> Vec<IntegerInterval> {
        let pairs = bounds
            .iter()
            .flat_map(|low| bounds.iter().map(move |high| (*low, *high)));
        let pairs = pairs.filter(|(low, high)| low <= high);
        pairs
            .map(|(low, high)| IntegerInterval { low, high })
            .collect()
    }

    /// Checks the computed intervals against the results for these numbers.
    fn check(bounds: &[i64], numbers: &[i64]) {
        let within = |interval: IntegerInterval| {
            let numbers = numbers.iter().copied();
            numbers.filter(move |number| (interval.low..=interval.high).contains(number))
        };
        for operation in OPERATIONS {
            for left in intervals(bounds) {
                for right in intervals(bounds) {
                    let (computed, overflows) = IntegerInterval::computed(operation, left, right);
                    assert!(
                        computed.low <= computed.high,
                        "{operation:?} {left:?} {right:?}"
                    );
                    for a in within(left) {
                        for b in within(right) {
                            let case = || format!("{a} {operation:?} {b} in {left:?}, {right:?}");
                            match result(operation, a, b) {
                                Some(number) => {
                                    let range = computed.low..=computed.high;
                                    assert!(range.contains(&number), "{number} = {}", case());
                                }
                                None if operation == Arithmetic::Mod => {}
                                None => assert!(overflows, "{}", case()),
                            }
                        }
                    }
                }
            }
        }
    }

    #[test]
    fn results_lie_in_the_computed_interval() {
        // exhaustive around zero
        let small: Vec<i64> = (-6..=6).collect();
        check(&small, &small);
        // and at the limits of 64 bits
        let extreme = [
            i64::MIN,
            i64::MIN + 1,
            -(1 << 32),
            -2,
            -1,
            0,
            1,
            2,
            1 << 32,
            i64::MAX - 1,
            i64::MAX,
        ];
        check(&extreme, &extreme);
    }

    #[test]
    fn small_intervals_are_computed_exactly() {
        let interval = |low, high| IntegerInterval { low, high };
        let of = |operation, left, right| IntegerInterval::computed(operation, left, right);
        let [plus, minus, mult, modulo] = OPERATIONS;
        assert_eq!(
            of(plus, interval(1, 2), interval(-3, 4)),
            (interval(-2, 6), false)
        );
        assert_eq!(
            of(minus, interval(1, 2), interval(-3, 4)),
            (interval(-3, 5), false)
        );
        assert_eq!(
            of(mult, interval(-2, 3), interval(-5, 4)),
            (interval(-15, 12), false)
        );
        assert_eq!(
            of(modulo, interval(0, 90), interval(7, 7)),
            (interval(0, 6), false)
        );
        assert_eq!(
            of(modulo, interval(-3, 90), interval(7, 7)),
            (interval(-3, 6), false)
        );
        let any = IntegerInterval::ANY;
        assert!(of(plus, any, interval(1, 1)).1);
        assert!(!of(plus, interval(0, i64::MAX - 1), interval(1, 1)).1);
    }

    #[test]
    fn an_interval_contains_the_intervals_joined_to_it() {
        let joined = IntegerInterval::of(3).or(IntegerInterval { low: -2, high: 1 });
        assert_eq!(joined, IntegerInterval { low: -2, high: 3 });
        assert!(IntegerInterval::of(3).within(3, 3) && !joined.within(-1, 3));
    }
}
