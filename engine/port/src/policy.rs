//! What a connection promises: Orocos RTT's `ConnPolicy`, and what a reader sees of old data.

use std::time::Duration;

use asmotion_connection::BufferKind;
use asmotion_derive::Word;
use serde::{Deserialize, Serialize};

/// How samples travel from an output port to an input port.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Policy {
    /// What is kept for the reader.
    pub kind: BufferKind,
    /// What keeps writers and readers apart.
    pub lock: Lock,
    /// Which connections have the queue in common.
    pub sharing: Sharing,
    /// Name of the queue that [`Sharing::Shared`] connections have in common (RTT `name_id`).
    pub queue: String,
    /// Whether a new reader gets at once what was last written before (RTT `init`; off by default).
    pub init: bool,
    /// Whether samples stay behind a pointer until the reader looks, which then copies and converts them; otherwise the
    /// writer does so for it (RTT `pull`; off by default).
    pub pull: bool,
    /// How many threads may use the queue; as many as there are ends, if absent.
    pub max_threads: Option<usize>,
    /// The age beyond which the newest sample is stale; unlimited if absent.
    pub max_age: Option<Duration>,
    /// What the reader sees of a stale sample.
    pub on_stale: OnStale,
    /// Whether a sample that does not fit is a fault of the writer, not just counted (RTT `mandatory`; off by default).
    pub mandatory: bool,
    /// Whether a sample triggers an event-driven reader (RTT event port; on by default).
    pub trigger: bool,
}

/// What keeps writers and readers apart (RTT `lock_policy`).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, Word)]
#[serde(rename_all = "snake_case")]
pub enum Lock {
    /// Nothing that anybody would wait for.
    #[default]
    LockFree,
    /// A lock: whoever comes second waits.
    Locked,
    /// Nothing: both ends are in one thread, the one in the other's by `System::slave`.
    Unsync,
}

/// Who has the queue of a buffer in common (RTT `buffer_policy`). Of the newest sample alone, every reader has its own.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, Word)]
#[serde(rename_all = "snake_case")]
pub enum Sharing {
    /// Nobody: each connection has one of its own.
    #[default]
    PerConnection,
    /// All connections into the input port: together they fill one queue.
    #[word("per_input_port")]
    PerInput,
    /// All connections from the output port: a sample goes to the reader that comes first.
    #[word("per_output_port")]
    PerOutput,
    /// All connections that name the same queue.
    Shared,
}

/// What the reader sees of a stale sample. `Cycle::is_stale` tells in any case.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, Word)]
#[serde(rename_all = "snake_case")]
pub enum OnStale {
    /// The sample, as before.
    #[default]
    Hold,
    /// No data.
    NoData,
    /// Once, a new sample of zeros, so that a command that stops coming becomes a stop.
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

    /// The newest sample.
    pub fn data() -> Self {
        Self::new(BufferKind::Data)
    }

    /// Every sample, so many; when full, the new one is dropped.
    pub fn buffer(size: usize) -> Self {
        Self::new(BufferKind::Buffer(size))
    }

    /// Every sample, so many; when full, the oldest is dropped.
    pub fn circular(size: usize) -> Self {
        Self::new(BufferKind::Circular(size))
    }

    /// With this to keep writers and readers apart.
    #[must_use]
    pub fn lock(self, lock: Lock) -> Self {
        Self { lock, ..self }
    }

    /// With its queue in common with these.
    #[must_use]
    pub fn sharing(self, sharing: Sharing) -> Self {
        Self { sharing, ..self }
    }

    /// With the queue of this name in common.
    #[must_use]
    pub fn shared(self, queue: impl Into<String>) -> Self {
        Self {
            sharing: Sharing::Shared,
            queue: queue.into(),
            ..self
        }
    }

    /// With what was last written before for a new reader.
    #[must_use]
    pub fn init(self) -> Self {
        Self { init: true, ..self }
    }

    /// With the reader to copy and convert.
    #[must_use]
    pub fn pull(self) -> Self {
        Self { pull: true, ..self }
    }

    /// With no more threads than these at its queue.
    #[must_use]
    pub fn max_threads(self, threads: usize) -> Self {
        Self {
            max_threads: Some(threads),
            ..self
        }
    }

    /// The same for a writer outside of the system, which has a thread of its own.
    pub fn for_outsider(&self) -> Self {
        Self {
            lock: match self.lock {
                Lock::Locked => Lock::Locked,
                Lock::LockFree | Lock::Unsync => Lock::LockFree,
            },
            sharing: Sharing::PerConnection,
            ..self.clone()
        }
    }

    /// With samples older than this stale.
    #[must_use]
    pub fn max_age(self, max_age: Duration) -> Self {
        Self {
            max_age: Some(max_age),
            ..self
        }
    }

    /// With this to be seen of stale samples.
    #[must_use]
    pub fn on_stale(self, on_stale: OnStale) -> Self {
        Self { on_stale, ..self }
    }

    /// With undelivered samples a fault of the writer.
    #[must_use]
    pub fn mandatory(self) -> Self {
        Self {
            mandatory: true,
            ..self
        }
    }

    /// Without triggering an event-driven reader.
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
