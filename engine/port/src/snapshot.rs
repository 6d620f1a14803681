//! Snapshots: the content of ports between two cycles, as data.

use asmotion_datum::{Datum, DatumError, DatumProblem, Message};
use serde::{Deserialize, Serialize};

use crate::sender::Stamped;
use crate::time::Time;

/// Content of an input port between two cycles.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct InputSnapshot {
    /// Samples that were new in the last cycle.
    pub(crate) fresh: Vec<Datum>,
    /// Newest sample of earlier cycles, as a list of at most one element.
    pub(crate) last: Vec<Datum>,
    /// Origin of the newest sample; `None` if there is none.
    pub(crate) newest: Option<NewestSnapshot>,
    /// Whether the newest sample exceeds the maximum age of its connection.
    pub(crate) stale: bool,
    /// Number of messages lost on the way into the port.
    pub(crate) lost: u64,
    /// Number of messages among them that were too old.
    pub(crate) too_old: u64,
    /// Causes of refusals that have been reported.
    pub(crate) causes: Vec<String>,
    /// Unread samples by connection number.
    pub channels: Vec<(u64, Vec<SampleSnapshot>)>,
}

/// Origin of the newest sample of an input.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct NewestSnapshot {
    pub at: Time,
    pub connection: u64,
    pub zeroed: bool,
}

/// Content of an output port between two cycles.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct OutputSnapshot {
    /// Sequence number of the last sample sent.
    pub(crate) sequence: u64,
    /// Last sample sent, as a list of at most one element.
    pub(crate) last: Vec<SampleSnapshot>,
    /// Number of samples dropped by each link.
    pub(crate) dropped: Vec<u64>,
}

/// An unread sample as data.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SampleSnapshot {
    /// Time of the writer's cycle.
    pub at: Time,
    /// Position among all samples of the run.
    pub order: u64,
    /// Content of the sample.
    pub value: Datum,
}

impl SampleSnapshot {
    /// Converts a sample of any type.
    pub(crate) fn of<T: Message>(sample: &Stamped<T>) -> Result<Self, DatumError> {
        Ok(Self {
            at: sample.at,
            order: sample.order,
            value: sample.value.to_datum()?,
        })
    }
}

/// Returns the error for a snapshot of a port with other links.
pub(crate) fn links_mismatch() -> DatumError {
    let problem = DatumProblem::Mismatch("the port has other connections".to_owned());
    DatumError::new(problem)
}
