//! The program a machine executes: slots and numbers.
//!
//! [`lower`] turns a resolved model into a [`Program`]. Every location of a function over finite
//! domains is a slot whose number is known or computed by a few multiplications; other locations are
//! interned when they are first met. Macros are specialised for the arguments that are passed by
//! name, so that a machine only knows calls by value. This is what a back end compiles.

mod code;
mod codes;
mod cover;
mod interval;
mod lower;
mod program;
mod visit;

pub use code::*;
pub use codes::CODES;
pub use cover::{Counted, Counter, CoveragePoint};
pub use interval::IntegerInterval;
pub use lower::{
    Lowered, MessageRole, MessageUse, lower, lower_with, message_uses, visit_rules, visit_terms,
};
pub use program::*;
