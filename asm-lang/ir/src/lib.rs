//! The intermediate representation: the program that a machine executes, with slots for locations
//! and numbers for names.
//!
//! [`lower`] turns a resolved model into a [`Program`], the input of every back end. Each location
//! of a function over finite domains is a slot whose number is known, or computed with one
//! multiplication for each argument; other locations are interned on first access. Macros are
//! specialised for arguments that must be passed by name, so a machine only has calls by value.

mod code;
mod codes;
mod counter;
mod cover;
mod id;
mod indexed;
mod interval;
mod lower;
mod program;
mod value_shape;
mod visit;

pub use code::*;
pub use codes::CODES;
pub use counter::{Counted, Counter, CoveragePoint};
pub use id::*;
pub use indexed::{IndexedGuard, first_conjunct};
pub use interval::IntegerInterval;
pub use lower::{
    Lowered, MAX_CREATED, MessageRole, MessageUse, UnreachedLiteral, applied_functions, is_watched,
    lower, lower_with, message_uses, read_functions, unreached_literals, visit_rules, visit_terms,
};
pub use program::*;
pub use value_shape::ValueShape;
