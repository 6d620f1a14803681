//! Waiting for a file descriptor with a time limit.

use std::os::fd::AsFd;
use std::time::Duration;

use rustix::event::{PollFd, PollFlags, Timespec, poll};

/// Waits until there is something to read, or for this time.
pub(crate) fn wait_readable(end: impl AsFd, limit: Duration) {
    let mut ends = [PollFd::new(&end, PollFlags::IN)];
    // an interrupted wait is a short one
    let _ = poll(&mut ends, Some(&timespec(limit)));
}

/// A time limit for `poll`.
pub(crate) fn timespec(limit: Duration) -> Timespec {
    Timespec {
        tv_sec: i64::try_from(limit.as_secs()).unwrap_or(i64::MAX),
        tv_nsec: limit.subsec_nanos().into(),
    }
}
