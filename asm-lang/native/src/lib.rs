//! Native code: a second back end for the main rule, where machines spend most of their time.
//!
//! The main rule and the macros that it calls become one function. It handles what needs only
//! scalars: integers, truth values and atoms in registers, locations whose arguments lie on known
//! axes, and the first update of a location. Everything else (undef, overflow, a second update of a
//! location) is left to a *detour*: the closure of the current rule or guard runs from its
//! beginning and yields the value, the fault or the clash. Starting again is sound, because terms
//! have no effects and an input keeps its value throughout a step. Steps are therefore identical in
//! both back ends.

mod agents;
mod atoms;
mod bound_range;
mod clash;
mod compile;
mod counted;
mod detour;
mod direct;
mod direct_code;
mod direct_frame;
mod direct_range;
mod direct_sequence;
mod emit;
mod frame;
mod limits;
mod location;
mod memory;
mod range;
mod range_guard;
mod rule;
mod sequence;
mod static_analysis;
mod switch;
mod term;
mod truth;
mod unfold;
mod unroll;
mod value_facts;

pub use compile::Cranelift;
