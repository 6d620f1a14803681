//! Ends a program with the process that started it, also if that process is killed.
#![allow(unsafe_code, reason = "a hook between fork and exec")]

use std::io;
use std::os::unix::process::CommandExt;
use std::process::Command;

use rustix::process::{Signal, getpid, getppid, set_parent_process_death_signal};

/// Lets the kernel kill the process of a command when the thread that starts it ends.
pub(crate) fn kill_with_parent(command: &mut Command) {
    let parent = getpid();
    let hook = move || {
        set_parent_process_death_signal(Some(Signal::KILL))?;
        // the parent can have ended before the call
        if getppid() == Some(parent) {
            Ok(())
        } else {
            Err(io::Error::from(rustix::io::Errno::SRCH))
        }
    };
    // SAFETY: after fork, only async-signal-safe functions may be called. The hook makes two system calls, and neither
    // allocates nor locks; an error is built from a number.
    unsafe {
        command.pre_exec(hook);
    }
}
