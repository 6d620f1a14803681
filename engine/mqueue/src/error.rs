//! What can be wrong with a queue, and with a type that shall pass through one.

/// Why a type has no form in this transport.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum UnsupportedTypeError {
    /// Something that is written as a pointer, or not at all.
    #[error("{}{what} has no form in a message queue", FieldPathPrefix(path))]
    NoForm {
        /// Path of field names to it.
        path: String,
        /// What it is: `string`.
        what: String,
    },
    /// Many of what has no bytes: how many could not be checked.
    #[error(
        "{}many of {what} take no bytes, however many there are",
        FieldPathPrefix(path)
    )]
    Nothing {
        /// Path of field names to it.
        path: String,
        /// The elements' type.
        what: String,
    },
}

/// Why a queue cannot be opened.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum QueueCheckError {
    /// No name of a queue.
    #[error("`{name}` is no name of a queue; one is a `/` and up to 255 characters that are none")]
    Name {
        /// As it was written.
        name: String,
    },
    /// Messages would have no bytes, or as many as a list happens to have.
    #[error(
        "how large are the messages of {queue}? {kind} has lists; say `data_size = BYTES`, the same as on the other side"
    )]
    NoSize {
        /// The queue.
        queue: String,
        /// The type.
        kind: String,
    },
    /// More messages than this system allows.
    #[error(
        "{queue} would hold {asked} messages, and this system allows {limit}; make the connection's `size` smaller, or raise the limit: `sysctl fs.mqueue.msg_max={asked}`"
    )]
    TooMany {
        /// The queue.
        queue: String,
        /// How many it would hold.
        asked: usize,
        /// How many are allowed.
        limit: usize,
    },
    /// Larger messages than this system allows.
    #[error(
        "messages of {queue} would have {asked} bytes, and this system allows {limit}; raise the limit: `sysctl fs.mqueue.msgsize_max={asked}`"
    )]
    TooLarge {
        /// The queue.
        queue: String,
        /// Bytes of a message.
        asked: usize,
        /// How many are allowed.
        limit: usize,
    },
    /// All queues of this user together would take too much.
    #[error(
        "{queue} would take {asked} bytes, and all queues of this user together may take {limit}; raise the limit with `ulimit -q`, or remove queues that nobody needs: `ls /dev/mqueue`"
    )]
    NoRoom {
        /// The queue.
        queue: String,
        /// Bytes it would take.
        asked: usize,
        /// How many all may take.
        limit: u64,
    },
    /// There are as many queues as the system allows.
    #[error(
        "there are as many queues as this system allows, so {queue} cannot be made; remove some (`ls /dev/mqueue`), or raise the limit: `sysctl fs.mqueue.queues_max`"
    )]
    NoMore {
        /// The queue.
        queue: String,
    },
    /// The queue is somebody else's.
    #[error("{queue} is there and belongs to another user")]
    Denied {
        /// The queue.
        queue: String,
    },
    /// A queue of this name takes smaller messages.
    #[error(
        "{queue} is there and takes messages of {takes} bytes, and these have {size}; give both sides the same type and `data_size`, and if nobody uses it any more, remove it: `rm /dev/mqueue{}`",
        queue.trim_start_matches("mqueue:")
    )]
    Smaller {
        /// The queue.
        queue: String,
        /// Bytes it takes.
        takes: usize,
        /// Bytes wanted.
        size: usize,
    },
    /// This system has no such queues.
    #[error("{queue}: this system has no POSIX message queues")]
    Unsupported {
        /// The queue.
        queue: String,
    },
    /// What the system says else.
    #[error("{queue}: {reason}")]
    System {
        /// The queue.
        queue: String,
        /// Its words.
        reason: String,
    },
}

/// `pose.name: ` in front of a problem, or nothing for the whole.
struct FieldPathPrefix<'a>(&'a str);

impl std::fmt::Display for FieldPathPrefix<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self.0 {
            "" => Ok(()),
            path => write!(f, "`{path}`: "),
        }
    }
}
