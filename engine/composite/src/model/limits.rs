//! Limits and defaults that several tables share.

/// Upper bound of all delays: one day, in milliseconds.
pub(super) const DAY_MS: u64 = 86_400_000;

/// Default time limit of a call, in milliseconds.
pub const DEFAULT_TIMEOUT_MS: u64 = 1000;
