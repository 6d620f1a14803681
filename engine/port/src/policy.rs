//! Connection policies: Orocos RTT's `ConnPolicy`, and the treatment of stale data.

use std::time::Duration;

use asmotion_connection::BufferKind;
use asmotion_derive::Word;
use serde::{Deserialize, Serialize};

/// The policy of a connection from an output port to an input port.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Policy {
    /// The samples that are kept for the reader.
    pub kind: BufferKind,
    /// Synchronisation of writers and readers.
    pub lock: Lock,
    /// The connections that share one queue.
    pub sharing: Sharing,
    /// Name of the queue of [`Sharing::Shared`] connections (RTT `name_id`); empty otherwise.
    pub queue: String,
    /// Whether a new reader receives the last written sample at once (RTT `init`; default: `false`).
    pub init: bool,
    /// Whether samples are kept as they were written, and copied and converted by the reader instead of the writer (RTT
    /// `pull`; default: `false`).
    pub pull: bool,
    /// Limit on the number of threads that use the queue; `None` for one thread per end.
    pub max_threads: Option<usize>,
    /// Age after which a sample is stale; `None` for no limit.
    pub max_age: Option<Duration>,
    /// The reader's view of a stale sample.
    pub on_stale: OnStale,
    /// Whether a sample that does not fit into the connection is a fault of the writer, and not only counted (RTT
    /// `mandatory`; default: `false`).
    pub mandatory: bool,
    /// Whether a sample triggers an event-driven reader (RTT event port; default: `true`).
    pub trigger: bool,
}

/// Synchronisation of writers and readers (RTT `lock_policy`).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, Word)]
#[serde(rename_all = "snake_case")]
pub enum Lock {
    /// Lock-free: neither side ever waits for the other.
    #[default]
    LockFree,
    /// A lock: one side may wait for the other.
    Locked,
    /// None: both ends are in the same thread, because one component is the `master` of the other.
    Unsync,
}

/// The connections that share a queue (RTT `buffer_policy`). Applies to buffers only; for the newest sample alone,
/// every reader has a copy of its own.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, Word)]
#[serde(rename_all = "snake_case")]
pub enum Sharing {
    /// None: each connection has its own queue.
    #[default]
    PerConnection,
    /// All connections into the input port share one queue.
    #[word("per_input_port")]
    PerInput,
    /// All connections from the output port share one queue; each sample goes to one of the readers.
    #[word("per_output_port")]
    PerOutput,
    /// All connections with the same queue name share one queue.
    Shared,
}

/// The reader's view of a stale sample. `Cycle::is_stale` is `true` in any case.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, Word)]
#[serde(rename_all = "snake_case")]
pub enum OnStale {
    /// The stale sample itself.
    #[default]
    Hold,
    /// No data, as before the first sample.
    NoData,
    /// A new sample of zeros, once, so that a velocity command becomes a stop if its writer falls silent.
    Zero,
}

impl Policy {
    fn new(kind: BufferKind) -> Self {
        Self {
            kind,
            lock: Lock::LockFree,
            sharing: Sharing::PerConnection,
            queue: String::new(),
            init: false,
            pull: false,
            max_threads: None,
            max_age: None,
            on_stale: OnStale::Hold,
            mandatory: false,
            trigger: true,
        }
    }

    /// A connection that keeps only the newest sample.
    pub fn data() -> Self {
        Self::new(BufferKind::Data)
    }

    /// A connection with a queue of `size` samples; when full, new samples are dropped.
    pub fn buffer(size: usize) -> Self {
        Self::new(BufferKind::Buffer(size))
    }

    /// A connection with a queue of `size` samples; when full, the oldest sample is dropped.
    pub fn circular(size: usize) -> Self {
        Self::new(BufferKind::Circular(size))
    }

    /// Sets the synchronisation of writers and readers.
    #[must_use]
    pub fn lock(self, lock: Lock) -> Self {
        Self { lock, ..self }
    }

    /// Sets the connections that share a queue.
    #[must_use]
    pub fn sharing(self, sharing: Sharing) -> Self {
        Self { sharing, ..self }
    }

    /// Shares the queue with this name.
    #[must_use]
    pub fn shared(self, queue: impl Into<String>) -> Self {
        Self {
            sharing: Sharing::Shared,
            queue: queue.into(),
            ..self
        }
    }

    /// Sends the last written sample to a new reader.
    #[must_use]
    pub fn init(self) -> Self {
        Self { init: true, ..self }
    }

    /// Makes the reader copy and convert samples.
    #[must_use]
    pub fn pull(self) -> Self {
        Self { pull: true, ..self }
    }

    /// Sets the limit on the number of threads that use the queue.
    #[must_use]
    pub fn max_threads(self, threads: usize) -> Self {
        Self {
            max_threads: Some(threads),
            ..self
        }
    }

    /// The policy for an end outside the system, which has its own thread: never unsynchronised, and with its own
    /// queue.
    pub fn for_external(&self) -> Self {
        Self {
            lock: match self.lock {
                Lock::Locked => Lock::Locked,
                Lock::LockFree | Lock::Unsync => Lock::LockFree,
            },
            sharing: Sharing::PerConnection,
            ..self.clone()
        }
    }

    /// Sets the age after which a sample is stale.
    #[must_use]
    pub fn max_age(self, max_age: Duration) -> Self {
        Self {
            max_age: Some(max_age),
            ..self
        }
    }

    /// Age after which a sample that the component has not read yet is discarded; `None` if the component uses samples of any
    /// age, or holds stale ones.
    pub fn discarded_after(&self) -> Option<Duration> {
        match self.on_stale {
            OnStale::Hold => None,
            OnStale::NoData | OnStale::Zero => self.max_age,
        }
    }

    /// Sets the reader's view of a stale sample.
    #[must_use]
    pub fn on_stale(self, on_stale: OnStale) -> Self {
        Self { on_stale, ..self }
    }

    /// Makes a sample that does not fit a fault of the writer.
    #[must_use]
    pub fn mandatory(self) -> Self {
        Self {
            mandatory: true,
            ..self
        }
    }

    /// Does not trigger an event-driven reader.
    #[must_use]
    pub fn silent(self) -> Self {
        Self {
            trigger: false,
            ..self
        }
    }
}

impl Default for Policy {
    fn default() -> Self {
        Self::data()
    }
}
