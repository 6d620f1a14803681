//! The values of the language: totally ordered, hashable, cheap to clone.
//!
//! A [`Value`] is two words: scalars lie in it, collections and texts are shared behind one thin
//! pointer. Equality, order and hash agree on every value, `Real` included (by the bits, so that a
//! set of reals and a trace are the same everywhere).

mod clone;
mod display;
pub mod layout;
mod real;
mod value;

pub use display::{DisplayValue, ValueNames, element_name};
pub use real::Real;
pub use value::{Atom, RuleId, Value};
