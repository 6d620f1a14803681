//! Limits and defaults that several tables share.

/// No wait is longer than a day.
pub(super) const DAY_MS: u64 = 86_400_000;

/// How long a call may take where the wire does not say.
pub const DEFAULT_TIMEOUT_MS: u64 = 1000;
