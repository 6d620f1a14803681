//! Snapshots: what ports hold between two cycles, as data.

use asmotion_datum::{Datum, DatumError, DatumProblem};
use serde::{Deserialize, Serialize};

use crate::sender::Stamped;
use crate::time::Time;

/// What an input port holds between two cycles.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct InputSnapshot {
    /// Samples that the last cycle saw as new.
    pub(crate) fresh: Vec<Datum>,
    /// The newest sample of earlier cycles: a list of one, or none.
    pub(crate) last: Vec<Datum>,
    /// Where the newest sample came from.
    pub(crate) newest: Option<NewestSnapshot>,
    /// Whether it is older than its connection promises.
    pub(crate) stale: bool,
    /// What waits in each connection, by its number.
    pub channels: Vec<(u64, Vec<SampleSnapshot>)>,
}

/// Where the newest sample of an input came from.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct NewestSnapshot {
    pub at: Time,
    pub connection: u64,
    pub zeroed: bool,
}

/// What an output port holds between two cycles.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct OutputSnapshot {
    /// Number of the last sample that left.
    pub(crate) sequence: u64,
    /// The last sample that left: a list of one, or none.
    pub(crate) last: Vec<SampleSnapshot>,
    /// Samples that each link has dropped.
    pub(crate) dropped: Vec<u64>,
}

/// A sample on its way, as data.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SampleSnapshot {
    /// The time of the writer's cycle.
    pub at: Time,
    /// Position among all samples of the run.
    pub order: u64,
    /// The sample itself.
    pub value: Datum,
}

impl SampleSnapshot {
    /// A sample of any type.
    pub(crate) fn of<T: serde::Serialize>(sample: &Stamped<T>) -> Result<Self, DatumError> {
        Ok(Self {
            at: sample.at,
            order: sample.order,
            value: Datum::of(&sample.value)?,
        })
    }
}

/// The error of a snapshot of a port with other links.
pub(crate) fn other_links() -> DatumError {
    let problem = DatumProblem::Mismatch("the port has other connections".to_owned());
    DatumError::new(problem)
}
