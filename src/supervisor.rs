//! A supervised process ends with its supervisor, also if that one is killed.

use rustix::process::{Pid, Signal, getpid, getppid, set_parent_process_death_signal};

/// Process id of the `asmotion up` that starts a process, as an argument for it.
pub(crate) fn own_id() -> String {
    getpid().as_raw_nonzero().to_string()
}

/// Lets the kernel send SIGTERM to this process when its supervisor ends, so that its components stop in order.
///
/// # Errors
/// An error if the supervisor has already ended.
pub(crate) fn end_with(supervisor: i32) -> Result<(), String> {
    // a kernel without the signal leaves the process as it is without a supervisor
    let _ = set_parent_process_death_signal(Some(Signal::TERM));
    // the supervisor can have ended before the call
    if getppid() == Pid::from_raw(supervisor) {
        Ok(())
    } else {
        Err(format!(
            "the supervisor of this process, {supervisor}, has ended"
        ))
    }
}
