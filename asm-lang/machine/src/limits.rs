//! How much a step may do: whatever the program, it ends with a fault rather than with the stack, the
//! memory or the patience used up. Fuzzers use smaller bounds, to get at them.

/// Calls may nest this deep.
pub(crate) const MAX_DEPTH: u32 = 20_000;

/// Calls of functions and rules in one step. More are a recursion that branches.
pub const MAX_CALLS: u32 = if cfg!(fuzzing) { 50_000 } else { 10_000_000 };

/// Rounds of all loops of one step together.
pub const MAX_ITERATIONS: u32 = if cfg!(fuzzing) { 50_000 } else { 10_000_000 };

/// Bindings of variables by `forall`, `choose`, comprehensions and quantifiers in one step.
pub const MAX_BINDINGS: u32 = if cfg!(fuzzing) { 50_000 } else { 10_000_000 };

/// Elements of a domain, a shape or a collection that are listed.
pub(crate) const MAX_ELEMENTS: u64 = if cfg!(fuzzing) { 1 << 14 } else { 1 << 20 };

/// Arguments of a function whose locations are found by index; those of more are found by hashing.
pub(crate) const MAX_AXES: usize = 4;
