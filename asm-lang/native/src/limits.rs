//! Limits of native code.

/// Limit for the number of rules of a native function, which bounds the time and the memory of its compilation.
pub(crate) const MAX_RULES: usize = 4_000;

/// Number of rules up to which a function is optimised.
pub(crate) const FEW_RULES: usize = 200;

/// Limit for the nesting of inlined macros and unfolded definitions.
pub(crate) const MAX_INLINED: usize = 48;

/// Limit for the iterations of a loop that is unrolled.
pub(crate) const MAX_UNROLLED: u64 = 8;

/// Limit for the parts of rules and terms of all iterations of a loop that is unrolled.
pub(crate) const MAX_UNROLLED_PARTS: u64 = 256;

/// Number of elements from which on a range within a loop is left to closures, which have an index for it.
pub(crate) const MIN_INDEXED: u64 = 64;
