//! Native code: the second back end, for the part of a program that machines spend their time on.
//!
//! The main rule, with the macros it calls built in, becomes one function. It does what needs scalars
//! only: integers, truth values and atoms in registers, locations of known axes read in place, updates
//! that are the first of their slot. The closures stay the reference. Wherever anything else comes up,
//! an undef, an overflow, a second update of a location, native code takes a *detour*: the closure of
//! the rule or guard at hand does it again from its beginning, and finds the value, the fault or the
//! clash as it always would. That is the same, because terms can be evaluated twice: they change
//! nothing, and what was asked of the environment holds for the whole step. So a step is the same
//! whichever back end does it.

mod compile;
mod detour;
mod emit;
mod frame;
mod known;
mod location;
mod memory;
mod rule;
mod sequence;
mod term;
mod truth;

pub use compile::Cranelift;
