//! Limits of a step. They guarantee that a step of any program ends with a fault before it exhausts
//! the stack, the memory or the user's patience. Fuzzing uses smaller limits in order to reach
//! them.

/// Limit for the nesting of calls.
pub(crate) const MAX_DEPTH: u32 = 20_000;

/// Limit for the calls of functions and rules in a step; exceeded by branching recursion.
pub const MAX_CALLS: u32 = if cfg!(fuzzing) { 50_000 } else { 10_000_000 };

/// Limit for the iterations of all loops in a step.
pub const MAX_ITERATIONS: u32 = if cfg!(fuzzing) { 50_000 } else { 10_000_000 };

/// Limit for the bindings of variables by `forall`, `choose`, comprehensions and quantifiers in a
/// step.
pub const MAX_BINDINGS: u32 = if cfg!(fuzzing) { 50_000 } else { 10_000_000 };

/// Limit for the elements of a domain, a shape or a collection that is enumerated.
pub(crate) const MAX_ELEMENTS: u64 = if cfg!(fuzzing) { 1 << 14 } else { 1 << 20 };

/// Limit for the arguments of a function whose locations are found by index; locations with more
/// arguments are found by hashing.
pub(crate) const MAX_AXES: usize = 4;
