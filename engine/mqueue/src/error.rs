//! Errors of queues and of the types of their messages.

/// The reason that a type cannot be sent through a queue.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum UnsupportedTypeError {
    /// A type without a fixed binary form: text, an option or an unknown type.
    #[error("{}{what} has no encoding in a message queue", FieldPathPrefix(path))]
    NoForm {
        /// Path of field names to it.
        path: String,
        /// Name of the type, for example `string`.
        what: String,
    },
    /// A list whose elements occupy no bytes, so that its length could not be checked.
    #[error("{}elements of {what} have no size", FieldPathPrefix(path))]
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
    #[error("invalid queue name `{name}`: write `/` and up to 255 characters other than `/`")]
    Name {
        /// The name as written.
        name: String,
    },
    /// The messages have no fixed size, or no bytes at all.
    #[error(
        "missing message size of {queue}: {kind} has lists; write `data_size = BYTES`, as on the other side"
    )]
    NoSize {
        /// Name of the queue.
        queue: String,
        /// Name of the message type.
        kind: String,
    },
    /// The queue would hold more messages than the system allows.
    #[error(
        "{queue} needs {requested} messages, but this system allows {limit}; reduce the connection's `size`, or raise the limit: `sysctl fs.mqueue.msg_max={requested}`"
    )]
    TooMany {
        /// Name of the queue.
        queue: String,
        /// Requested number of messages.
        requested: usize,
        /// The system's limit.
        limit: usize,
    },
    /// The messages would be larger than the system allows.
    #[error(
        "messages of {queue} need {requested} bytes, but this system allows {limit}; raise the limit: `sysctl fs.mqueue.msgsize_max={requested}`"
    )]
    TooLarge {
        /// Name of the queue.
        queue: String,
        /// Requested size of a message, in bytes.
        requested: usize,
        /// The system's limit, in bytes.
        limit: usize,
    },
    /// The queues of this user would exceed their limit on memory.
    #[error(
        "{queue} needs {requested} bytes, but all queues of this user together may have {limit}; raise the limit with `ulimit -q`, or remove unused queues: `ls /dev/mqueue`"
    )]
    NoRoom {
        /// Name of the queue.
        queue: String,
        /// Bytes requested for this queue.
        requested: usize,
        /// Limit on the sum over all queues, in bytes.
        limit: u64,
    },
    /// The system's limit on the number of queues is reached.
    #[error(
        "cannot create {queue}: this system has its maximum number of queues; remove some (`ls /dev/mqueue`), or raise the limit: `sysctl fs.mqueue.queues_max`"
    )]
    NoMore {
        /// Name of the queue.
        queue: String,
    },
    /// The queue belongs to another user.
    #[error("{queue} belongs to another user")]
    Denied {
        /// Name of the queue.
        queue: String,
    },
    /// A queue with this name exists, for smaller messages.
    #[error(
        "{queue} has messages of {required} bytes, but these have {size}; use the same type and `data_size` on both sides, and remove the queue if it is unused: `rm /dev/mqueue{}`",
        queue.trim_start_matches("mqueue:")
    )]
    Smaller {
        /// Name of the queue.
        queue: String,
        /// Message size of the existing queue, in bytes.
        required: usize,
        /// Message size needed, in bytes.
        size: usize,
    },
    /// This operating system has no POSIX message queues.
    #[error("{queue}: this system has no POSIX message queues")]
    Unsupported {
        /// Name of the queue.
        queue: String,
    },
    /// Another process of ours has the same end of the queue.
    #[error(
        "another process {does} {queue}, perhaps another run of this system; stop it (`fuser {file}` shows its number), or give this connection another queue"
    )]
    Claimed {
        /// Name of the queue.
        queue: String,
        /// What the other process does: `writes to` or `reads from`.
        does: &'static str,
        /// The file that the other process has locked.
        file: String,
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
