//! Errors of queues and of the types of their messages.

/// The reason that a type cannot be sent through a queue.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum UnsupportedTypeError {
    /// A type without a fixed binary form: text, an option or an unknown type.
    #[error("{}{what} has no form in a message queue", FieldPathPrefix(path))]
    NoForm {
        /// Path of field names to it.
        path: String,
        /// Name of the type, for example `string`.
        what: String,
    },
    /// A list whose elements occupy no bytes, so that its length could not be checked.
    #[error(
        "{}many of {what} take no bytes, however many there are",
        FieldPathPrefix(path)
    )]
    Nothing {
        /// Path of field names to it.
        path: String,
        /// Name of the elements' type.
        what: String,
    },
}

/// The reason that a queue cannot be opened.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum QueueCheckError {
    /// An invalid name.
    #[error("`{name}` is no name of a queue; one is a `/` and up to 255 characters that are none")]
    Name {
        /// The name as written.
        name: String,
    },
    /// The messages have no fixed size, or no bytes at all.
    #[error(
        "how large are the messages of {queue}? {kind} has lists; say `data_size = BYTES`, the same as on the other side"
    )]
    NoSize {
        /// Name of the queue.
        queue: String,
        /// Name of the message type.
        kind: String,
    },
    /// The queue would hold more messages than the system allows.
    #[error(
        "{queue} would hold {asked} messages, and this system allows {limit}; make the connection's `size` smaller, or raise the limit: `sysctl fs.mqueue.msg_max={asked}`"
    )]
    TooMany {
        /// Name of the queue.
        queue: String,
        /// Requested number of messages.
        asked: usize,
        /// The system's limit.
        limit: usize,
    },
    /// The messages would be larger than the system allows.
    #[error(
        "messages of {queue} would have {asked} bytes, and this system allows {limit}; raise the limit: `sysctl fs.mqueue.msgsize_max={asked}`"
    )]
    TooLarge {
        /// Name of the queue.
        queue: String,
        /// Requested size of a message, in bytes.
        asked: usize,
        /// The system's limit, in bytes.
        limit: usize,
    },
    /// The queues of this user would exceed their limit on memory.
    #[error(
        "{queue} would take {asked} bytes, and all queues of this user together may take {limit}; raise the limit with `ulimit -q`, or remove queues that nobody needs: `ls /dev/mqueue`"
    )]
    NoRoom {
        /// Name of the queue.
        queue: String,
        /// Bytes requested for this queue.
        asked: usize,
        /// Limit on the sum over all queues, in bytes.
        limit: u64,
    },
    /// The system's limit on the number of queues is reached.
    #[error(
        "there are as many queues as this system allows, so {queue} cannot be made; remove some (`ls /dev/mqueue`), or raise the limit: `sysctl fs.mqueue.queues_max`"
    )]
    NoMore {
        /// Name of the queue.
        queue: String,
    },
    /// The queue belongs to another user.
    #[error("{queue} is there and belongs to another user")]
    Denied {
        /// Name of the queue.
        queue: String,
    },
    /// A queue with this name exists, for smaller messages.
    #[error(
        "{queue} is there and takes messages of {takes} bytes, and these have {size}; give both sides the same type and `data_size`, and if nobody uses it any more, remove it: `rm /dev/mqueue{}`",
        queue.trim_start_matches("mqueue:")
    )]
    Smaller {
        /// Name of the queue.
        queue: String,
        /// Message size of the existing queue, in bytes.
        takes: usize,
        /// Message size needed, in bytes.
        size: usize,
    },
    /// This operating system has no POSIX message queues.
    #[error("{queue}: this system has no POSIX message queues")]
    Unsupported {
        /// Name of the queue.
        queue: String,
    },
    /// Any other error of the operating system.
    #[error("{queue}: {reason}")]
    System {
        /// Name of the queue.
        queue: String,
        /// The operating system's message.
        reason: String,
    },
}

/// Displays `pose.name: ` before a problem, or nothing for an empty path.
struct FieldPathPrefix<'a>(&'a str);

impl std::fmt::Display for FieldPathPrefix<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self.0 {
            "" => Ok(()),
            path => write!(f, "`{path}`: "),
        }
    }
}
