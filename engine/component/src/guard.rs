//! Confines panics to the component whose code panicked.

use std::panic::{AssertUnwindSafe, catch_unwind};

use crate::fault::Fault;

/// Runs a component's code and converts a panic into a fault.
///
/// # Errors
/// The fault that `code` returns, or one with the message of its panic.
pub fn guarded<R>(code: impl FnOnce() -> Result<R, Fault>) -> Result<R, Fault> {
    // unwind safe: after a panic, the runtime calls only the component's own stop and clean-up hooks, so no other code
    // sees its state
    catch_unwind(AssertUnwindSafe(code)).unwrap_or_else(|payload| Err(Fault::of_panic(&*payload)))
}
