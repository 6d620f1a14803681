//! The border around a component's code.

use std::panic::{AssertUnwindSafe, catch_unwind};

use crate::fault::Fault;

/// Runs a component's code; a panic is a fault like another.
pub fn guarded<R>(code: impl FnOnce() -> Result<R, Fault>) -> Result<R, Fault> {
    // After a panic the component is not called again but to stop and clean up; it sees what it left behind.
    catch_unwind(AssertUnwindSafe(code)).unwrap_or_else(|payload| Err(Fault::of_panic(&*payload)))
}
