//! Reals: 64-bit floats with IEEE 754 arithmetic and comparison. Only conversions to Integer and
//! Natural can fail.

use crate::argument::{binary, unary};
use crate::builtin::{Builtin, strict};
use crate::fault::BuiltinFault;
use crate::to_string::TO_STRING;
use asmotion_value::Real;

/// Addition according to IEEE 754; overflow is infinite.
#[inline]
pub fn plus(left: f64, right: f64) -> f64 {
    left + right
}

/// Subtraction according to IEEE 754; overflow is infinite.
#[inline]
pub fn minus(left: f64, right: f64) -> f64 {
    left - right
}

/// Multiplication according to IEEE 754; overflow is infinite.
#[inline]
pub fn mult(left: f64, right: f64) -> f64 {
    left * right
}

/// Division; infinite or NaN for a divisor of zero.
#[inline]
pub fn div(left: f64, right: f64) -> f64 {
    left / right
}

/// Power `base ^ exponent`.
#[inline]
pub fn pwr(base: f64, exponent: f64) -> f64 {
    base.powf(exponent)
}

/// Unary plus: returns the number itself.
#[inline]
pub fn plus_sign(operand: f64) -> f64 {
    operand
}

/// Negation, also of infinities and zeros.
#[inline]
pub fn negate(operand: f64) -> f64 {
    -operand
}

/// Absolute value; NaN for NaN.
#[inline]
pub fn abs(operand: f64) -> f64 {
    operand.abs()
}

/// Square root; NaN for a negative number.
#[inline]
pub fn sqrt(operand: f64) -> f64 {
    operand.sqrt()
}

/// Returns the greater of two numbers; NaN if either is, and `0.0` for `0.0` and `-0.0` (IEEE 754
/// `maximum`).
#[inline]
pub fn max(left: f64, right: f64) -> f64 {
    if left.is_nan() || right.is_nan() {
        f64::NAN
    } else {
        Real::new(left).max(Real::new(right)).get()
    }
}

/// Returns the lesser of two numbers; NaN if either is, and `-0.0` for `0.0` and `-0.0` (IEEE 754
/// `minimum`).
#[inline]
pub fn min(left: f64, right: f64) -> f64 {
    if left.is_nan() || right.is_nan() {
        f64::NAN
    } else {
        Real::new(left).min(Real::new(right)).get()
    }
}

/// Returns `true` if `left < right` in IEEE 754: false with a NaN, and `-0.0` equals `0.0`.
#[inline]
pub fn lt(left: f64, right: f64) -> bool {
    left < right
}

/// Returns `true` if `left <= right`; false with a NaN.
#[inline]
pub fn le(left: f64, right: f64) -> bool {
    left <= right
}

/// Returns `true` if `left > right`; false with a NaN.
#[inline]
pub fn gt(left: f64, right: f64) -> bool {
    left > right
}

/// Returns `true` if `left >= right`; false with a NaN.
#[inline]
pub fn ge(left: f64, right: f64) -> bool {
    left >= right
}

/// Returns the greatest integer less than or equal to the number.
///
/// # Errors
/// [`BuiltinFault::NotInteger`] if the result does not fit in 64 bits.
#[inline]
pub fn floor(operand: f64) -> Result<i64, BuiltinFault> {
    whole("floor", operand, operand.floor())
}

/// Returns the nearest integer; halves are rounded away from zero, `round(-2.5) = -3`.
///
/// # Errors
/// [`BuiltinFault::NotInteger`] if the result does not fit in 64 bits.
#[inline]
pub fn round(operand: f64) -> Result<i64, BuiltinFault> {
    whole("round", operand, operand.round())
}

/// Truncates towards zero.
///
/// # Errors
/// [`BuiltinFault::NotInteger`] if the result does not fit in 64 bits.
#[inline]
pub fn to_integer(operand: f64) -> Result<i64, BuiltinFault> {
    whole("rtoi", operand, operand.trunc())
}

/// Truncates towards zero and converts to a natural.
///
/// # Errors
/// [`BuiltinFault::NotInteger`] if the result does not fit in 64 bits, [`BuiltinFault::Negative`]
/// for -1.0 and less.
#[inline]
pub fn to_natural(operand: f64) -> Result<i64, BuiltinFault> {
    let number = whole("rton", operand, operand.trunc())?;
    if number < 0 {
        return Err(BuiltinFault::Negative {
            function: "rton",
            number,
        });
    }
    Ok(number)
}

/// Converts the whole number `rounded` to an integer; `operand` is shown in the fault.
fn whole(function: &'static str, operand: f64, rounded: f64) -> Result<i64, BuiltinFault> {
    // 2^63 is a double but no i64, -2^63 is both; NaN is in no range
    const END: f64 = 9_223_372_036_854_775_808.0;
    if (-END..END).contains(&rounded) {
        Ok(rounded as i64)
    } else {
        Err(BuiltinFault::NotInteger {
            function,
            number: Real::new(operand),
        })
    }
}

pub(crate) const TABLE: &[Builtin] = &[
    strict("plus", "Real", |arguments, _| unary(arguments, plus_sign)),
    strict("minus", "Real", |arguments, _| unary(arguments, negate)),
    strict("plus", "Prod(Real,Real)", |arguments, _| {
        binary(arguments, plus)
    }),
    strict("minus", "Prod(Real,Real)", |arguments, _| {
        binary(arguments, minus)
    }),
    strict("mult", "Prod(Real,Real)", |arguments, _| {
        binary(arguments, mult)
    }),
    strict("div", "Prod(Real,Real)", |arguments, _| {
        binary(arguments, div)
    }),
    strict("pwr", "Prod(Real,Real)", |arguments, _| {
        binary(arguments, pwr)
    }),
    strict("sqrt", "Real", |arguments, _| unary(arguments, sqrt)),
    strict("abs", "Real", |arguments, _| unary(arguments, abs)),
    strict("max", "Prod(Real,Real)", |arguments, _| {
        binary(arguments, max)
    }),
    strict("min", "Prod(Real,Real)", |arguments, _| {
        binary(arguments, min)
    }),
    strict("lt", "Prod(Real,Real)", |arguments, _| {
        binary(arguments, lt)
    }),
    strict("le", "Prod(Real,Real)", |arguments, _| {
        binary(arguments, le)
    }),
    strict("gt", "Prod(Real,Real)", |arguments, _| {
        binary(arguments, gt)
    }),
    strict("ge", "Prod(Real,Real)", |arguments, _| {
        binary(arguments, ge)
    }),
    strict("toString", "Real", TO_STRING),
    strict("floor", "Real", |arguments, _| unary(arguments, floor)),
    strict("round", "Real", |arguments, _| unary(arguments, round)),
    strict("rtoi", "Real", |arguments, _| unary(arguments, to_integer)),
    strict("rton", "Real", |arguments, _| unary(arguments, to_natural)),
];

/// Functions that differ in the reference tools: conversions saturate, and NaN becomes 0.
pub(crate) const COMPATIBLE: &[Builtin] = &[
    strict("rtoi", "Real", |arguments, _| {
        unary(arguments, |number: f64| number as i64)
    }),
    strict("rton", "Real", |arguments, _| {
        unary(arguments, |number: f64| number as i64)
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
            check(
                name,
                "Prod(Real,Real)",
                &[real(left), real(right)],
                expected,
            );
        };
        two("plus", 0.1, 0.2, "0.30000000000000004");
        two("minus", 1.0, 1.5, "-0.5");
        two("mult", -0.0, 3.0, "-0.0");
        two("div", 1.0, 0.0, "inf");
        two("div", 1.0, -0.0, "-inf");
        two("div", 0.0, 0.0, "NaN");
        two("pwr", -2.0, 2.0, "4.0");
        two("pwr", 2.0, 0.5, "1.4142135623730951");
        two("max", 1.0, 2.0, "2.0");
        two("max", -0.0, 0.0, "0.0");
        two("max", f64::NAN, 0.0, "NaN");
        two("min", 0.0, -0.0, "-0.0");
        two("min", 0.0, f64::NAN, "NaN");
        let one = |name, operand, expected| check(name, "Real", &[real(operand)], expected);
        one("plus", -1.5, "-1.5");
        one("minus", 0.0, "-0.0");
        one("abs", -1.5, "1.5");
        one("sqrt", 2.25, "1.5");
        one("sqrt", -1.0, "NaN");
        check("plus", "Prod(Real,Real)", &[UNDEF, real(1.0)], "undef");
        check(
            "plus",
            "Prod(Real,Real)",
            &[int(1), real(1.0)],
            "expected a Real, found an Integer",
        );
    }

    #[test]
    fn comparison_is_that_of_ieee() {
        // the left operand against 0.0: lt, le, gt, ge
        for (left, results) in [
            (-1.0, "true true false false"),
            (0.0, "false true false true"),
            (-0.0, "false true false true"),
            (1.0, "false false true true"),
            (f64::NAN, "false false false false"),
        ] {
            for (name, expected) in ["lt", "le", "gt", "ge"].into_iter().zip(results.split(' ')) {
                check(name, "Prod(Real,Real)", &[real(left), real(0.0)], expected);
            }
        }
    }

    #[test]
    fn conversion() {
        let one = |name, operand, expected| check(name, "Real", &[real(operand)], expected);
        one("floor", -2.5, "-3");
        one(
            "floor",
            -9_223_372_036_854_775_808.0,
            "-9223372036854775808",
        );
        one(
            "floor",
            9_223_372_036_854_775_808.0,
            "`floor(9.223372036854776e18)` does not fit into a 64-bit integer",
        );
        one(
            "floor",
            f64::NAN,
            "`floor(NaN)` does not fit into a 64-bit integer",
        );
        one("round", 2.5, "3");
        one("round", -2.5, "-3");
        one("round", 0.499_999_999_999_999_94, "0");
        one(
            "round",
            f64::INFINITY,
            "`round(inf)` does not fit into a 64-bit integer",
        );
        one("rtoi", -2.5, "-2");
        one("rtoi", -0.0, "0");
        one(
            "rtoi",
            1e300,
            "`rtoi(1e300)` does not fit into a 64-bit integer",
        );
        one("rton", 2.5, "2");
        one("rton", -0.5, "0");
        one("rton", -2.5, "expected a Natural for `rton`, found -2");
    }

    proptest! {
        #[test]
        fn floor_is_the_integer_below(number in -1e15..1e15) {
            let floor = floor(number).map(|whole| whole as f64);
            prop_assert!(floor.is_ok_and(|whole| whole <= number && number < whole + 1.0));
        }

        #[test]
        fn an_integer_survives_the_way_there_and_back(number in -(1_i64 << 53)..(1 << 53)) {
            prop_assert_eq!(to_integer(number as f64), Ok(number));
            prop_assert_eq!(round(number as f64), Ok(number));
        }
    }
}
