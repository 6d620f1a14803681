//! What a connection promises.

use std::time::Duration;

use serde::{Deserialize, Serialize};

/// How samples travel from an output port to an input port.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Policy {
    /// What is kept for the reader.
    pub kind: Kind,
    /// The age beyond which the newest sample is stale; unlimited if absent.
    pub max_age: Option<Duration>,
    /// What the reader sees of a stale sample.
    pub on_stale: OnStale,
    /// Whether a sample that does not fit is a fault of the writer, not just counted (RTT `mandatory`; off by default).
    pub mandatory: bool,
    /// Whether a sample triggers an event-driven reader (RTT event port; on by default).
    pub trigger: bool,
}

/// What is kept for the reader.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Kind {
    /// The newest sample (RTT DATA). What it replaces was not lost: it was out of date.
    Data,
    /// So many samples; when full, the new one is dropped and counted (RTT BUFFER).
    Buffer(usize),
    /// So many samples; when full, the oldest is dropped and counted (RTT CIRCULAR_BUFFER).
    Circular(usize),
}

/// What the reader sees of a stale sample. [`Cycle::is_stale`](crate::Cycle::is_stale) tells in any case.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum OnStale {
    /// The sample, as before.
    #[default]
    Keep,
    /// No data.
    Forget,
    /// Once, a new sample of zeros, so that a command that stops coming becomes a stop.
    Zero,
}

impl Policy {
    fn new(kind: Kind) -> Self {
        Self {
            kind,
            max_age: None,
            on_stale: OnStale::Keep,
            mandatory: false,
            trigger: true,
        }
    }

    /// The newest sample.
    pub fn data() -> Self {
        Self::new(Kind::Data)
    }

    /// Every sample, so many; when full, the new one is dropped.
    pub fn buffer(size: usize) -> Self {
        Self::new(Kind::Buffer(size))
    }

    /// Every sample, so many; when full, the oldest is dropped.
    pub fn circular(size: usize) -> Self {
        Self::new(Kind::Circular(size))
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
