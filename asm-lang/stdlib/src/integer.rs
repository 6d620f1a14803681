//! Integers of 64 bits with checked arithmetic: overflow is a fault.

use crate::argument::{binary, unary};
use crate::builtin::{Builtin, strict};
use crate::fault::BuiltinFault;
use crate::to_string::TO_STRING;

/// Checked addition.
///
/// # Errors
/// [`BuiltinFault::Overflow`] if the result does not fit in 64 bits.
#[inline]
pub fn plus(left: i64, right: i64) -> Result<i64, BuiltinFault> {
    left.checked_add(right).ok_or(BuiltinFault::Overflow {
        function: "plus",
        left,
        right,
    })
}

/// Checked subtraction.
///
/// # Errors
/// [`BuiltinFault::Overflow`] if the result does not fit in 64 bits.
#[inline]
pub fn minus(left: i64, right: i64) -> Result<i64, BuiltinFault> {
    left.checked_sub(right).ok_or(BuiltinFault::Overflow {
        function: "minus",
        left,
        right,
    })
}

/// Checked multiplication.
///
/// # Errors
/// [`BuiltinFault::Overflow`] if the result does not fit in 64 bits.
#[inline]
pub fn mult(left: i64, right: i64) -> Result<i64, BuiltinFault> {
    left.checked_mul(right).ok_or(BuiltinFault::Overflow {
        function: "mult",
        left,
        right,
    })
}

/// Division with a real result. Total as in IEEE 754: `1 / 0` is infinite and `0 / 0` is NaN.
/// Operands beyond 53 bits are rounded first.
#[inline]
pub fn div(left: i64, right: i64) -> f64 {
    left as f64 / right as f64
}

/// Division truncated towards zero: `idiv(-7, 2) = -3`.
///
/// # Errors
/// [`BuiltinFault::ZeroDivisor`], or [`BuiltinFault::Overflow`] for the least integer divided by
/// -1.
#[inline]
pub fn idiv(left: i64, right: i64) -> Result<i64, BuiltinFault> {
    if right == 0 {
        return Err(BuiltinFault::ZeroDivisor {
            function: "idiv",
            dividend: left,
        });
    }
    left.checked_div(right).ok_or(BuiltinFault::Overflow {
        function: "idiv",
        left,
        right,
    })
}

/// Remainder of [`idiv`], with the sign of the dividend: `-7 mod 2 = -1`.
///
/// # Errors
/// [`BuiltinFault::ZeroDivisor`] if `right` is 0.
#[inline]
pub fn modulo(left: i64, right: i64) -> Result<i64, BuiltinFault> {
    if right == 0 {
        return Err(BuiltinFault::ZeroDivisor {
            function: "mod",
            dividend: left,
        });
    }
    // not `checked_rem`: the least integer mod -1 is 0, although the quotient overflows
    Ok(left.wrapping_rem(right))
}

/// Unary plus: returns the number itself.
#[inline]
pub fn plus_sign(operand: i64) -> i64 {
    operand
}

/// Checked negation.
///
/// # Errors
/// [`BuiltinFault::OverflowOf`] for the least integer.
#[inline]
pub fn negate(operand: i64) -> Result<i64, BuiltinFault> {
    operand.checked_neg().ok_or(BuiltinFault::OverflowOf {
        function: "minus",
        operand,
    })
}

/// Checked absolute value.
///
/// # Errors
/// [`BuiltinFault::OverflowOf`] for the least integer.
#[inline]
pub fn abs(operand: i64) -> Result<i64, BuiltinFault> {
    operand.checked_abs().ok_or(BuiltinFault::OverflowOf {
        function: "abs",
        operand,
    })
}

/// Returns the greater of two numbers.
#[inline]
pub fn max(left: i64, right: i64) -> i64 {
    left.max(right)
}

/// Returns the lesser of two numbers.
#[inline]
pub fn min(left: i64, right: i64) -> i64 {
    left.min(right)
}

/// Returns `true` if `left < right`.
#[inline]
pub fn lt(left: i64, right: i64) -> bool {
    left < right
}

/// Returns `true` if `left <= right`.
#[inline]
pub fn le(left: i64, right: i64) -> bool {
    left <= right
}

/// Returns `true` if `left > right`.
#[inline]
pub fn gt(left: i64, right: i64) -> bool {
    left > right
}

/// Returns `true` if `left >= right`.
#[inline]
pub fn ge(left: i64, right: i64) -> bool {
    left >= right
}

/// Converts to the nearest real; exact up to 53 bits.
#[inline]
pub fn to_real(operand: i64) -> f64 {
    operand as f64
}

/// Converts to a natural.
///
/// # Errors
/// [`BuiltinFault::Negative`] for a negative number.
#[inline]
pub fn to_natural(operand: i64) -> Result<i64, BuiltinFault> {
    if operand < 0 {
        return Err(BuiltinFault::Negative {
            function: "iton",
            number: operand,
        });
    }
    Ok(operand)
}

/// Converts a size to an integer.
pub(crate) fn of(size: usize) -> i64 {
    i64::try_from(size).unwrap_or(i64::MAX)
}

pub(crate) const TABLE: &[Builtin] = &[
    strict("plus", "Integer", |arguments, _| {
        unary(arguments, plus_sign)
    }),
    strict("minus", "Integer", |arguments, _| unary(arguments, negate)),
    strict("plus", "Prod(Integer,Integer)", |arguments, _| {
        binary(arguments, plus)
    }),
    strict("minus", "Prod(Integer,Integer)", |arguments, _| {
        binary(arguments, minus)
    }),
    strict("mult", "Prod(Integer,Integer)", |arguments, _| {
        binary(arguments, mult)
    }),
    strict("div", "Prod(Integer,Integer)", |arguments, _| {
        binary(arguments, div)
    }),
    strict("idiv", "Prod(Integer,Integer)", |arguments, _| {
        binary(arguments, idiv)
    }),
    strict("mod", "Prod(Integer,Integer)", |arguments, _| {
        binary(arguments, modulo)
    }),
    strict("abs", "Integer", |arguments, _| unary(arguments, abs)),
    strict("max", "Prod(Integer,Integer)", |arguments, _| {
        binary(arguments, max)
    }),
    strict("min", "Prod(Integer,Integer)", |arguments, _| {
        binary(arguments, min)
    }),
    strict("lt", "Prod(Integer,Integer)", |arguments, _| {
        binary(arguments, lt)
    }),
    strict("le", "Prod(Integer,Integer)", |arguments, _| {
        binary(arguments, le)
    }),
    strict("gt", "Prod(Integer,Integer)", |arguments, _| {
        binary(arguments, gt)
    }),
    strict("ge", "Prod(Integer,Integer)", |arguments, _| {
        binary(arguments, ge)
    }),
    strict("toString", "Integer", TO_STRING),
    strict("itor", "Integer", |arguments, _| unary(arguments, to_real)),
    strict("iton", "Integer", |arguments, _| {
        unary(arguments, to_natural)
    }),
    strict("ntor", "Integer", |arguments, _| unary(arguments, to_real)),
    // Integer with Natural: both have the same representation, so the same functions apply
    strict("mult", "Prod(Natural,Integer)", |arguments, _| {
        binary(arguments, mult)
    }),
    strict("mult", "Prod(Integer,Natural)", |arguments, _| {
        binary(arguments, mult)
    }),
    strict("mod", "Prod(Natural,Integer)", |arguments, _| {
        binary(arguments, modulo)
    }),
    strict("mod", "Prod(Integer,Natural)", |arguments, _| {
        binary(arguments, modulo)
    }),
    strict("lt", "Prod(Natural,Integer)", |arguments, _| {
        binary(arguments, lt)
    }),
    strict("lt", "Prod(Integer,Natural)", |arguments, _| {
        binary(arguments, lt)
    }),
    strict("le", "Prod(Natural,Integer)", |arguments, _| {
        binary(arguments, le)
    }),
    strict("le", "Prod(Integer,Natural)", |arguments, _| {
        binary(arguments, le)
    }),
    strict("gt", "Prod(Natural,Integer)", |arguments, _| {
        binary(arguments, gt)
    }),
    strict("gt", "Prod(Integer,Natural)", |arguments, _| {
        binary(arguments, gt)
    }),
    strict("ge", "Prod(Natural,Integer)", |arguments, _| {
        binary(arguments, ge)
    }),
    strict("ge", "Prod(Integer,Natural)", |arguments, _| {
        binary(arguments, ge)
    }),
];

/// Functions that differ in the reference tools: arithmetic wraps around, and conversions are
/// unchecked.
pub(crate) const COMPATIBLE: &[Builtin] = &[
    strict("plus", "Prod(Integer,Integer)", |arguments, _| {
        binary(arguments, i64::wrapping_add)
    }),
    strict("minus", "Prod(Integer,Integer)", |arguments, _| {
        binary(arguments, i64::wrapping_sub)
    }),
    strict("mult", "Prod(Integer,Integer)", |arguments, _| {
        binary(arguments, i64::wrapping_mul)
    }),
    strict("iton", "Integer", |arguments, _| {
        unary(arguments, |number: i64| number)
    }),
];

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::*;
    use proptest::prelude::*;

    #[test]
    fn arithmetic() {
        let two = |name, left, right, expected| {
            check(name, "Prod(Integer,Integer)", &[left, right], expected);
        };
        two("plus", int(2), int(3), "5");
        two(
            "plus",
            MAX,
            int(1),
            "`plus(9223372036854775807, 1)` does not fit into a 64-bit integer",
        );
        two("minus", int(2), int(3), "-1");
        two(
            "minus",
            MIN,
            int(1),
            "`minus(-9223372036854775808, 1)` does not fit into a 64-bit integer",
        );
        two("mult", int(-4), int(3), "-12");
        two(
            "mult",
            MIN,
            int(-1),
            "`mult(-9223372036854775808, -1)` does not fit into a 64-bit integer",
        );
        two("div", int(7), int(2), "3.5");
        two("div", int(1), int(0), "inf");
        two("div", int(0), int(0), "NaN");
        two("idiv", int(7), int(2), "3");
        two("idiv", int(-7), int(2), "-3");
        two("idiv", int(7), int(0), "`idiv(7, 0)` divides by zero");
        two(
            "idiv",
            MIN,
            int(-1),
            "`idiv(-9223372036854775808, -1)` does not fit into a 64-bit integer",
        );
        two("mod", int(-7), int(2), "-1");
        two("mod", int(7), int(-2), "1");
        two("mod", int(7), int(0), "`mod(7, 0)` divides by zero");
        two("mod", MIN, int(-1), "0");
        two("max", int(-1), MIN, "-1");
        two("min", int(-1), MIN, "-9223372036854775808");
        two("plus", UNDEF, int(1), "undef");
        two("idiv", UNDEF, int(0), "undef");
        let one = |name, operand, expected| check(name, "Integer", &[operand], expected);
        one("plus", int(-3), "-3");
        one("minus", int(-3), "3");
        one(
            "minus",
            MIN,
            "`minus(-9223372036854775808)` does not fit into a 64-bit integer",
        );
        one("abs", int(-3), "3");
        one(
            "abs",
            MIN,
            "`abs(-9223372036854775808)` does not fit into a 64-bit integer",
        );
    }

    #[test]
    fn conversion() {
        check("itor", "Integer", &[int(3)], "3.0");
        check("iton", "Integer", &[int(3)], "3");
        check(
            "iton",
            "Integer",
            &[int(-3)],
            "expected a Natural for `iton`, found -3",
        );
        check("ntor", "Integer", &[int(-3)], "-3.0");
    }

    #[test]
    fn comparison() {
        for domain in [
            "Prod(Integer,Integer)",
            "Prod(Natural,Integer)",
            "Prod(Integer,Natural)",
        ] {
            for (name, results) in [
                ("lt", ["true", "false", "false"]),
                ("le", ["true", "true", "false"]),
                ("gt", ["false", "false", "true"]),
                ("ge", ["false", "true", "true"]),
            ] {
                for (left, expected) in [1, 2, 3].into_iter().zip(results) {
                    check(name, domain, &[int(left), int(2)], expected);
                }
                check(name, domain, &[int(1), UNDEF], "undef");
            }
        }
        for domain in ["Prod(Natural,Integer)", "Prod(Integer,Natural)"] {
            check("mult", domain, &[int(2), int(3)], "6");
            check("mod", domain, &[int(7), int(4)], "3");
        }
    }

    proptest! {
        #[test]
        fn quotient_and_remainder_make_the_dividend(a: i64, b: i64) {
            if let (Ok(quotient), Ok(remainder)) = (idiv(a, b), modulo(a, b)) {
                prop_assert_eq!(i128::from(quotient) * i128::from(b) + i128::from(remainder), i128::from(a));
                prop_assert!(remainder == 0 || (remainder < 0) == (a < 0));
            } else {
                prop_assert!(b == 0 || (a, b) == (i64::MIN, -1));
            }
        }

        #[test]
        fn what_fits_is_exact_and_the_rest_faults(a: i64, b: i64) {
            for (ours, exact) in [
                (plus(a, b), i128::from(a) + i128::from(b)),
                (minus(a, b), i128::from(a) - i128::from(b)),
                (mult(a, b), i128::from(a) * i128::from(b)),
            ] {
                prop_assert_eq!(ours.ok(), i64::try_from(exact).ok());
            }
        }
    }
}
