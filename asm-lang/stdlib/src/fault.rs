//! Why a function has no value for its arguments.

use asmotion_value::Real;
use std::sync::Arc;

/// The most elements a function may put into one collection or text. A specification that doubles
/// a sequence at every step meets this fault, not the end of the memory.
pub const LIMIT: usize = if cfg!(fuzzing) { 1 << 14 } else { 1 << 24 };

/// What stops a function. The message shows the values; [`BuiltinFault::help`] a way out.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum BuiltinFault {
    /// A result of two integers that 64 bits cannot hold.
    #[error("`{function}({left}, {right})` is outside the integers of 64 bits")]
    Overflow {
        /// The function.
        function: &'static str,
        /// Its first argument.
        left: i64,
        /// Its second argument.
        right: i64,
    },
    /// A result of one integer that 64 bits cannot hold.
    #[error("`{function}({operand})` is outside the integers of 64 bits")]
    OverflowOf {
        /// The function.
        function: &'static str,
        /// Its argument.
        operand: i64,
    },
    /// An integer division by zero.
    #[error("`{function}({dividend}, 0)` divides by zero")]
    ZeroDivisor {
        /// The function.
        function: &'static str,
        /// What was to be divided.
        dividend: i64,
    },
    /// A real that no integer of 64 bits is near to.
    #[error("`{function}({:?})` is outside the integers of 64 bits", number.get())]
    NotInteger {
        /// The function.
        function: &'static str,
        /// Its argument: too large, infinite, or not a number.
        number: Real,
    },
    /// A negative number where a Natural is wanted.
    #[error("`{function}` meets {number}, and a Natural is not negative")]
    Negative {
        /// The function.
        function: &'static str,
        /// The number.
        number: i64,
    },
    /// A position outside a sequence, a tuple or a text.
    #[error("`{function}` asks for position {position} of {length}")]
    Position {
        /// The function.
        function: &'static str,
        /// The position.
        position: i64,
        /// How many there are.
        length: usize,
    },
    /// A part that does not lie within the whole.
    #[error("`{function}` asks for {from} to {to} of {length}")]
    Part {
        /// The function.
        function: &'static str,
        /// The first position wanted.
        from: i64,
        /// The position after the last one wanted.
        to: i64,
        /// How many there are.
        length: usize,
    },
    /// An element of an empty sequence or text.
    #[error("`{function}` of nothing: the argument is empty")]
    Empty {
        /// The function.
        function: &'static str,
    },
    /// A text that does not read as the value wanted.
    #[error("`{function}` cannot read {text:?} as {expected}")]
    Unreadable {
        /// The function.
        function: &'static str,
        /// The text.
        text: Arc<str>,
        /// What was expected, as in "an integer".
        expected: &'static str,
    },
    /// A sum with an element that is no number, or with numbers of different domains.
    #[error("`sum` cannot add {right} to {left}")]
    Sum {
        /// The kind of the sum so far.
        left: &'static str,
        /// The kind of the next element.
        right: &'static str,
    },
    /// A result of more elements than [`LIMIT`].
    #[error("`{function}` would make {size} elements, more than {LIMIT}")]
    TooLarge {
        /// The function.
        function: &'static str,
        /// How many it would make.
        size: usize,
    },
    /// Arguments that the signature excludes: the caller did not check the types.
    #[error("expected {expected}, found {found}")]
    Shape {
        /// What the body can take.
        expected: &'static str,
        /// The kind of value it was given.
        found: &'static str,
    },
}

impl BuiltinFault {
    /// What the author of the specification can do about it.
    pub fn help(&self) -> &'static str {
        match self {
            Self::Overflow { .. } | Self::OverflowOf { .. } => {
                "keep the numbers smaller, or compute with Real"
            }
            Self::ZeroDivisor { .. } => {
                "guard the division with `if d != 0 then ...`, or divide reals, where it is lawful"
            }
            Self::NotInteger { .. } => {
                "keep the number as a Real, or bound it with `max` and `min` first"
            }
            Self::Negative { .. } => "use an Integer, or guard with `if n >= 0 then ...`",
            Self::Position { .. } | Self::Part { .. } => {
                "positions count from 0; compare with `length` (of a text: `size`) first"
            }
            Self::Empty { .. } => "guard with `if not isEmpty(s) then ...` (of a text: `size`)",
            Self::Unreadable { .. } => "check the text before it is converted",
            Self::Sum { .. } => "sum numbers of one domain; convert with `itor` or `ntoi` first",
            Self::TooLarge { .. } => "let collections grow by a bounded amount",
            Self::Shape { .. } => "this is a bug of the tool, not of the specification: report it",
        }
    }
}
