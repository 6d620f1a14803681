//! The search for other descriptors of a queue, in `/proc`.
//!
//! A queue of the kernel does not tell who has it open, so the descriptors of all processes are examined. Processes of
//! other users cannot be examined without privileges, and those outside of our namespace of process ids are invisible;
//! [`HolderSearch::complete`] says whether there may be such processes.

use std::fs;
use std::os::fd::{AsFd, AsRawFd, RawFd};
use std::os::unix::fs::MetadataExt;
use std::path::{Path, PathBuf};

use nix::libc;

use super::KernelQueue;

/// Another descriptor of a queue: of another process, or another one of this process.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct QueueHolder {
    /// `/proc/PROCESS/fd/NUMBER`.
    descriptor: PathBuf,
}

/// The descriptors that a search takes into account.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum HolderAccess {
    /// All descriptors.
    Any,
    /// Those that can send messages.
    Writing,
}

/// The outcome of a search.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct HolderSearch {
    /// The other descriptors.
    pub found: Vec<QueueHolder>,
    /// `true` if every process that may have the queue open was examined.
    pub complete: bool,
}

/// The kernel's number of the initial namespace of process ids.
const INITIAL_NAMESPACE: &str = "pid:[4026531836]";

impl KernelQueue {
    /// Searches all visible processes for other descriptors of this queue. Takes milliseconds.
    pub(crate) fn find_holders(&self, access: HolderAccess) -> HolderSearch {
        let namespace = fs::read_link("/proc/self/ns/pid");
        let mut search = HolderSearch {
            found: Vec::new(),
            complete: namespace.is_ok_and(|name| name == Path::new(INITIAL_NAMESPACE)),
        };
        let (Some(number), Ok(processes)) = (self.number(), fs::read_dir("/proc")) else {
            search.complete = false;
            return search;
        };
        let own = format!("/proc/{}/fd/{number}", std::process::id());
        for process in processes.flatten() {
            let is_process = |name: &str| name.bytes().all(|byte| byte.is_ascii_digit());
            if !process.file_name().to_str().is_some_and(is_process) {
                continue;
            }
            match fs::read_dir(process.path().join("fd")) {
                Ok(descriptors) => {
                    let others = descriptors
                        .flatten()
                        .map(|entry| entry.path())
                        .filter(|path| path != Path::new(&own))
                        .map(|descriptor| QueueHolder { descriptor });
                    search.found.extend(others.filter(|other| {
                        self.is_held_by(other) && (access == HolderAccess::Any || other.can_write())
                    }));
                }
                // the process has ended in the meantime
                Err(error) if error.kind() == std::io::ErrorKind::NotFound => {}
                Err(_) => search.complete = false,
            }
        }
        search
    }

    /// Returns whether a descriptor, found earlier, still refers to this queue.
    pub(crate) fn is_held_by(&self, holder: &QueueHolder) -> bool {
        // the link first: `metadata` of a file of a remote file system may block
        let Ok(link) = fs::read_link(&holder.descriptor) else {
            return false;
        };
        let link = link.to_string_lossy();
        let link = link.strip_suffix(" (deleted)").unwrap_or(&link);
        if !link.ends_with(self.name.as_str()) {
            return false;
        }
        let Some(number) = self.number() else {
            return false;
        };
        let ours = fs::metadata(format!("/proc/self/fd/{number}"));
        let theirs = fs::metadata(&holder.descriptor);
        ours.ok()
            .zip(theirs.ok())
            .is_some_and(|(ours, theirs)| (ours.dev(), ours.ino()) == (theirs.dev(), theirs.ino()))
    }

    fn number(&self) -> Option<RawFd> {
        let open = self.descriptor().ok()?;
        Some(open.as_fd().as_raw_fd())
    }
}

impl QueueHolder {
    fn can_write(&self) -> bool {
        let (Some(process), Some(number)) = (
            self.descriptor.parent().and_then(Path::parent),
            self.descriptor.file_name(),
        ) else {
            return false;
        };
        let Ok(text) = fs::read_to_string(process.join("fdinfo").join(number)) else {
            return false;
        };
        let flags = text.lines().find_map(|line| line.strip_prefix("flags:"));
        let flags = flags.and_then(|flags| i32::from_str_radix(flags.trim(), 8).ok());
        flags.is_some_and(|flags| flags & libc::O_ACCMODE != libc::O_RDONLY)
    }
}
