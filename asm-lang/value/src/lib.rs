//! The values of the language: totally ordered, hashable, cheap to clone.
//!
//! A [`Value`] is two words: scalars are stored inline, collections and strings behind a shared
//! thin pointer. Equality, order and hash agree for every value, including `Real`, which compares
//! by bits, so that sets of reals and traces are the same on every machine.

mod clone;
mod display;
pub mod layout;
mod real;
mod value;

pub use display::{DisplayValue, ValueNames, element_name};
pub use real::Real;
pub use value::{Atom, RuleId, Value};
