//! Complex numbers: pairs of reals with the usual arithmetic.

use crate::argument::{FromValue, IntoValue, binary, unary};
use crate::builtin::{Builtin, strict};
use crate::fault::BuiltinFault;
use crate::to_string::TO_STRING;
use asmotion_value::{Real, Value};
use std::sync::Arc;

/// A complex number in Cartesian form.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Complex {
    /// The real part `a` of `a + bi`.
    pub re: f64,
    /// The imaginary part `b` of `a + bi`.
    pub im: f64,
}

impl Complex {
    /// Creates a number from its real and imaginary part.
    pub fn new(re: f64, im: f64) -> Self {
        Self { re, im }
    }

    /// Converts to a value.
    pub fn value(self) -> Value {
        Value::Complex(Arc::new((Real::new(self.re), Real::new(self.im))))
    }
}

impl From<(Real, Real)> for Complex {
    fn from((re, im): (Real, Real)) -> Self {
        Self::new(re.get(), im.get())
    }
}

impl FromValue<'_> for Complex {
    const EXPECTED: &'static str = "a Complex";
    fn read(value: &Value) -> Option<Self> {
        let Value::Complex(parts) = value else {
            return None;
        };
        Some(Self::from(**parts))
    }
}

impl IntoValue for Complex {
    fn answer(self) -> Result<Value, BuiltinFault> {
        Ok(self.value())
    }
}

/// Addition, component by component.
pub fn plus(left: Complex, right: Complex) -> Complex {
    Complex::new(left.re + right.re, left.im + right.im)
}

/// Subtraction, component by component.
pub fn minus(left: Complex, right: Complex) -> Complex {
    Complex::new(left.re - right.re, left.im - right.im)
}

/// Multiplication: `(a + bi)(c + di) = (ac - bd) + (ad + bc)i`.
pub fn mult(left: Complex, right: Complex) -> Complex {
    Complex::new(
        left.re * right.re - left.im * right.im,
        left.re * right.im + left.im * right.re,
    )
}

/// Division; both parts of the result are NaN for a divisor of zero.
pub fn div(left: Complex, right: Complex) -> Complex {
    let square = right.re * right.re + right.im * right.im;
    let product = mult(left, Complex::new(right.re, -right.im));
    Complex::new(product.re / square, product.im / square)
}

/// Multiplication by a real number.
pub fn scale(factor: f64, operand: Complex) -> Complex {
    Complex::new(factor * operand.re, factor * operand.im)
}

/// Negation of both parts.
pub fn negate(operand: Complex) -> Complex {
    Complex::new(-operand.re, -operand.im)
}

/// Modulus, as a complex number because the library declares its codomain as Complex.
pub fn norm(operand: Complex) -> Complex {
    Complex::new(operand.re.hypot(operand.im), 0.0)
}

/// Returns `true` if both parts are zero, of either sign.
pub fn is_zero(operand: Complex) -> bool {
    operand.re == 0.0 && operand.im == 0.0
}

pub(crate) const TABLE: &[Builtin] = &[
    strict("re", "Complex", |arguments, _| {
        unary(arguments, |number: Complex| number.re)
    }),
    strict("im", "Complex", |arguments, _| {
        unary(arguments, |number: Complex| number.im)
    }),
    strict("minus", "Complex", |arguments, _| unary(arguments, negate)),
    strict("plus", "Prod(Complex,Complex)", |arguments, _| {
        binary(arguments, plus)
    }),
    strict("minus", "Prod(Complex,Complex)", |arguments, _| {
        binary(arguments, minus)
    }),
    strict("mult", "Prod(Complex,Complex)", |arguments, _| {
        binary(arguments, mult)
    }),
    strict("div", "Prod(Complex,Complex)", |arguments, _| {
        binary(arguments, div)
    }),
    strict("norm", "Complex", |arguments, _| unary(arguments, norm)),
    strict("iszero", "Complex", |arguments, _| {
        unary(arguments, is_zero)
    }),
    strict("toString", "Complex", TO_STRING),
];

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::*;

    fn complex(re: f64, im: f64) -> Value {
        Complex::new(re, im).value()
    }

    #[test]
    fn arithmetic() {
        let two = |name, left, right, expected| {
            check(name, "Prod(Complex,Complex)", &[left, right], expected);
        };
        two("plus", complex(1.0, 2.0), complex(3.0, -4.0), "4.0-i2.0");
        two("minus", complex(1.0, 2.0), complex(3.0, -4.0), "-2.0+i6.0");
        two("mult", complex(0.0, 1.0), complex(0.0, 1.0), "-1.0+i0.0");
        two("div", complex(1.0, 2.0), complex(0.0, 1.0), "2.0-i1.0");
        two("div", complex(1.0, 2.0), complex(0.0, 0.0), "NaN+iNaN");
        two("mult", complex(0.0, 1.0), UNDEF, "undef");
        let one = |name, operand, expected| check(name, "Complex", &[operand], expected);
        one("re", complex(1.0, 2.0), "1.0");
        one("im", complex(1.0, 2.0), "2.0");
        one("minus", complex(1.0, 2.0), "-1.0-i2.0");
        one("norm", complex(3.0, -4.0), "5.0+i0.0");
        one("iszero", complex(0.0, -0.0), "true");
        one("iszero", complex(0.0, 1.0), "false");
        one("toString", complex(1.0, -2.0), r#""1.0-i2.0""#);
    }
}
