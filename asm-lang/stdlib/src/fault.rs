//! Faults of standard functions: arguments for which a function is undefined.

use asmotion_value::Real;
use std::sync::Arc;

/// Limit for the elements of a collection or string that a function creates. A specification that
/// doubles a sequence in every step ends with a fault rather than by exhausting the memory.
pub const LIMIT: usize = if cfg!(fuzzing) { 1 << 14 } else { 1 << 24 };

/// The reason that a function is undefined for its arguments. The message shows the values;
/// [`BuiltinFault::help`] suggests a remedy.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum BuiltinFault {
    /// The result of a binary integer operation does not fit in 64 bits.
    #[error("`{function}({left}, {right})` does not fit into a 64-bit integer")]
    Overflow {
        /// Name of the function.
        function: &'static str,
        /// First argument.
        left: i64,
        /// Second argument.
        right: i64,
    },
    /// The result of a unary integer operation does not fit in 64 bits.
    #[error("`{function}({operand})` does not fit into a 64-bit integer")]
    OverflowOf {
        /// Name of the function.
        function: &'static str,
        /// The argument whose result does not fit.
        operand: i64,
    },
    /// Integer division by zero.
    #[error("`{function}({dividend}, 0)` divides by zero")]
    ZeroDivisor {
        /// Name of the function.
        function: &'static str,
        /// The number to be divided.
        dividend: i64,
    },
    /// A real is outside the range of 64-bit integers.
    #[error("`{function}({:?})` does not fit into a 64-bit integer", number.get())]
    NotInteger {
        /// Name of the function.
        function: &'static str,
        /// The argument: too large, infinite, or NaN.
        number: Real,
    },
    /// A negative number where a Natural is required.
    #[error("expected a Natural for `{function}`, found {number}")]
    Negative {
        /// Name of the function.
        function: &'static str,
        /// The number, less than 0.
        number: i64,
    },
    /// A position outside a sequence, a tuple or a string.
    #[error("position {position} of `{function}` is outside a length of {length}")]
    Position {
        /// Name of the function.
        function: &'static str,
        /// The position, counted from 0.
        position: i64,
        /// Number of elements, or of characters of a string.
        length: usize,
    },
    /// A range of positions outside a sequence or string.
    #[error("range {from} to {to} of `{function}` is outside a length of {length}")]
    Part {
        /// Name of the function.
        function: &'static str,
        /// First position of the range.
        from: i64,
        /// Position after the last one of the range.
        to: i64,
        /// Number of elements, or of characters of a string.
        length: usize,
    },
    /// Access to an element of an empty sequence or string.
    #[error("`{function}` of an empty argument")]
    Empty {
        /// Name of the function.
        function: &'static str,
    },
    /// A string that does not denote a value of the required domain.
    #[error("`{function}` cannot parse {text:?} as {expected}")]
    Unreadable {
        /// Name of the function.
        function: &'static str,
        /// The string, unabridged.
        text: Arc<str>,
        /// Description of the required value, as in "an integer".
        expected: &'static str,
    },
    /// A sum with an element that is not a number, or with numbers of different domains.
    #[error("`sum` cannot add {right} to {left}")]
    Sum {
        /// Kind of the sum so far.
        left: &'static str,
        /// Kind of the next element.
        right: &'static str,
    },
    /// A result with more than [`LIMIT`] elements.
    #[error("`{function}` would create {size} elements, more than {LIMIT}")]
    TooLarge {
        /// Name of the function.
        function: &'static str,
        /// Number of elements of the result.
        size: usize,
    },
    /// An argument outside the signature, passed by a caller that did not check types.
    #[error("expected {expected}, found {found}")]
    Shape {
        /// Description of the required value.
        expected: &'static str,
        /// Kind of the given value.
        found: &'static str,
    },
}

impl BuiltinFault {
    /// Suggests a remedy to the author of the specification.
    pub fn help(&self) -> &'static str {
        match self {
            Self::Overflow { .. } | Self::OverflowOf { .. } => {
                "keep the numbers smaller, or use Real"
            }
            Self::ZeroDivisor { .. } => {
                "guard the division with `if d != 0 then ...`, or divide reals"
            }
            Self::NotInteger { .. } => {
                "keep the number as a Real, or bound it with `max` and `min` first"
            }
            Self::Negative { .. } => "use an Integer, or guard with `if n >= 0 then ...`",
            Self::Position { .. } | Self::Part { .. } => {
                "positions start at 0; compare with `length`, or with `size` for a string"
            }
            Self::Empty { .. } => {
                "guard with `if not isEmpty(s) then ...`, or with `size` for a string"
            }
            Self::Unreadable { .. } => "check the string before the conversion",
            Self::Sum { .. } => "sum numbers of one domain, or convert with `itor` or `ntoi`",
            Self::TooLarge { .. } => "limit the growth of the collection",
            Self::Shape { .. } => "report this as a bug of asmotion",
        }
    }
}
