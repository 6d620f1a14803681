//! Message queues of the Linux kernel. Only [`KernelQueue::wait`] blocks.

mod holder;

use std::os::fd::AsFd;
use std::time::Duration;

use nix::errno::Errno;
use nix::mqueue::{
    MQ_OFlag, MqAttr, MqdT, mq_attr_member_t, mq_close, mq_getattr, mq_open, mq_receive, mq_send,
    mq_unlink,
};
use nix::poll::{PollFd, PollFlags, PollTimeout, poll};
use nix::sys::resource::{Resource, getrlimit};
use nix::sys::stat::{Mode, fstat};

use crate::capacity::QueueCapacity;
use crate::error::QueueCheckError;
use crate::name::QueueName;
use crate::queue_priority::QueuePriority;

pub(crate) use holder::{HolderAccess, QueueHolder};

/// An open queue, which is closed on drop.
pub(crate) struct KernelQueue {
    name: QueueName,
    /// `None` only while the queue is being closed.
    descriptor: Option<MqdT>,
    /// Size of the largest message, in bytes.
    size: usize,
}

/// The outcome of sending a message.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum SendOutcome {
    Stored,
    Full,
}

/// The process that created a queue.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum QueueOrigin {
    /// This process, when it opened the queue.
    Created,
    /// An earlier process: the queue was there.
    Found,
}

/// Number of attempts to create or else open a queue.
const ATTEMPTS: usize = 10;

impl KernelQueue {
    /// Opens a queue for writing, and creates it if it does not exist. Also opens it for reading, so that the writer
    /// can remove the oldest message.
    pub(crate) fn create(
        name: &QueueName,
        capacity: QueueCapacity,
    ) -> Result<(Self, QueueOrigin), QueueCheckError> {
        let member =
            |number: usize| mq_attr_member_t::try_from(number).unwrap_or(mq_attr_member_t::MAX);
        let attributes = MqAttr::new(0, member(capacity.messages), member(capacity.size), 0);
        let new = MQ_OFlag::O_CREAT | MQ_OFlag::O_EXCL | MQ_OFlag::O_RDWR;
        let mut problem = Errno::ENOENT;
        // between the two attempts, another process may create or remove the queue
        for _ in 0..ATTEMPTS {
            match Self::open(name, new, Some(&attributes)) {
                Ok(queue) => return Ok((queue, QueueOrigin::Created)),
                Err(Errno::EEXIST) => {}
                Err(errno) => return Err(refusal(name, capacity, errno)),
            }
            match Self::open(name, MQ_OFlag::O_RDWR, None) {
                Ok(queue) => return Ok((queue, QueueOrigin::Found)),
                Err(errno) => problem = errno,
            }
            if problem != Errno::ENOENT {
                break;
            }
        }
        Err(refusal(name, capacity, problem))
    }

    /// Opens a queue for reading. Returns `None` if it does not exist.
    pub(crate) fn open_existing(name: &QueueName) -> Result<Option<Self>, QueueCheckError> {
        match Self::open(name, MQ_OFlag::O_RDONLY, None) {
            Ok(queue) => Ok(Some(queue)),
            Err(Errno::ENOENT) => Ok(None),
            Err(Errno::EACCES) => Err(QueueCheckError::Denied {
                queue: name.to_string(),
            }),
            Err(errno) => Err(system(name, errno)),
        }
    }

    fn open(name: &QueueName, flags: MQ_OFlag, attributes: Option<&MqAttr>) -> Result<Self, Errno> {
        let flags = flags | MQ_OFlag::O_NONBLOCK | MQ_OFlag::O_CLOEXEC;
        let descriptor = mq_open(
            name.as_str(),
            flags,
            Mode::S_IRUSR | Mode::S_IWUSR,
            attributes,
        )?;
        let mut queue = Self {
            name: name.clone(),
            descriptor: Some(descriptor),
            size: 0,
        };
        let attributes = mq_getattr(queue.descriptor()?)?;
        queue.size = usize::try_from(attributes.msgsize()).unwrap_or(0);
        Ok(queue)
    }

    fn descriptor(&self) -> Result<&MqdT, Errno> {
        self.descriptor.as_ref().ok_or(Errno::EBADF)
    }

    /// Size of the largest message, in bytes.
    pub(crate) fn size(&self) -> usize {
        self.size
    }

    /// Number of messages in the queue.
    pub(crate) fn count(&self) -> usize {
        let attributes = self.descriptor().and_then(mq_getattr);
        // cannot fail for an open queue
        attributes.map_or(0, |attributes| {
            usize::try_from(attributes.curmsgs()).unwrap_or(0)
        })
    }

    /// Adds a message if there is room.
    pub(crate) fn push(
        &self,
        message: &[u8],
        priority: QueuePriority,
    ) -> Result<SendOutcome, QueueCheckError> {
        let sent = self
            .descriptor()
            .and_then(|open| mq_send(open, message, priority.number()));
        match sent {
            Ok(()) => Ok(SendOutcome::Stored),
            Err(Errno::EAGAIN) => Ok(SendOutcome::Full),
            Err(Errno::EMSGSIZE) => Err(QueueCheckError::Smaller {
                queue: self.name.to_string(),
                required: self.size,
                size: message.len(),
            }),
            Err(errno) => Err(system(&self.name, errno)),
        }
    }

    /// Removes the oldest message, if there is one. Returns its size in bytes and its priority.
    pub(crate) fn pop(
        &self,
        buffer: &mut [u8],
    ) -> Result<Option<(usize, QueuePriority)>, QueueCheckError> {
        let mut priority = 0;
        let received = self
            .descriptor()
            .and_then(|open| mq_receive(open, buffer, &mut priority));
        match received {
            Ok(bytes) => Ok(Some((bytes, QueuePriority::of(priority)))),
            Err(Errno::EAGAIN | Errno::EINTR) => Ok(None),
            Err(errno) => Err(system(&self.name, errno)),
        }
    }

    /// Waits until there is a message, at most this long.
    pub(crate) fn wait(&self, timeout: Duration) {
        let Ok(open) = self.descriptor() else { return };
        let milliseconds = u16::try_from(timeout.as_millis()).unwrap_or(u16::MAX);
        let mut polled = [PollFd::new(open.as_fd(), PollFlags::POLLIN)];
        // after an interruption too, the caller checks the queue itself
        let _ = poll(&mut polled, PollTimeout::from(milliseconds));
    }

    /// Returns whether the queue's name has been removed, so that new messages under this name go to another queue.
    pub(crate) fn is_unlinked(&self) -> bool {
        let status = self.descriptor().and_then(|open| fstat(open.as_fd()));
        status.is_ok_and(|status| status.st_nlink == 0)
    }

    /// Removes the queue's name. Processes that have the queue open can still use it.
    pub(crate) fn unlink(&self) {
        // fails if the name has been removed already
        let _ = mq_unlink(self.name.as_str());
    }
}

impl Drop for KernelQueue {
    fn drop(&mut self) {
        if let Some(descriptor) = self.descriptor.take() {
            // an error leaves nothing to do
            let _ = mq_close(descriptor);
        }
    }
}

fn system(name: &QueueName, errno: Errno) -> QueueCheckError {
    QueueCheckError::System {
        queue: name.to_string(),
        reason: errno.desc().to_lowercase(),
    }
}

/// Explains why a queue was not created. The kernel's error code is not specific, so this compares the request with the
/// limits.
fn refusal(name: &QueueName, capacity: QueueCapacity, errno: Errno) -> QueueCheckError {
    let queue = name.to_string();
    let limit = |which: &str| -> Option<usize> {
        let text = std::fs::read_to_string(format!("/proc/sys/fs/mqueue/{which}")).ok()?;
        text.trim().parse().ok()
    };
    #[expect(
        clippy::wildcard_enum_match_arm,
        reason = "the enum lists all errors of the operating system"
    )]
    match errno {
        Errno::EACCES => QueueCheckError::Denied { queue },
        Errno::ENOSPC => QueueCheckError::NoMore { queue },
        Errno::EINVAL | Errno::ENOMEM | Errno::EOVERFLOW => {
            match (limit("msg_max"), limit("msgsize_max")) {
                (Some(limit), _) if capacity.messages > limit => QueueCheckError::TooMany {
                    queue,
                    requested: capacity.messages,
                    limit,
                },
                (_, Some(limit)) if capacity.size > limit => QueueCheckError::TooLarge {
                    queue,
                    requested: capacity.size,
                    limit,
                },
                _ => system(name, errno),
            }
        }
        // the kernel's code for queues that are too large for the user's limit
        Errno::EMFILE => match getrlimit(Resource::RLIMIT_MSGQUEUE) {
            Ok((limit, _))
                if capacity.messages.saturating_mul(capacity.size) as u64 > limit / 2 =>
            {
                QueueCheckError::NoRoom {
                    queue,
                    requested: capacity.messages.saturating_mul(capacity.size),
                    limit,
                }
            }
            Ok(_) | Err(_) => system(name, errno),
        },
        errno => system(name, errno),
    }
}
