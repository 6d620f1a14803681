//! The recording of a mission as MCAP.

#[cfg(not(feature = "mcap"))]
mod left_out;
#[cfg(feature = "mcap")]
mod recorder;

use std::path::PathBuf;

use asmotion_plan::Plan;
use asmotion_recording::RecordingProfile;

#[cfg(not(feature = "mcap"))]
pub(super) use left_out::MissionRecorder;
#[cfg(feature = "mcap")]
pub(super) use recorder::MissionRecorder;

/// Request to record a mission as MCAP.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct RecordingRequest {
    /// Name of the file; a file that exists is kept, and the new one gets a number. `None` leaves it to the composite.
    pub file: Option<String>,
    /// Ports and topics to record, as patterns; all of them if this is empty. Without a file, the composite selects topics.
    pub ports: Vec<String>,
    /// Readers of the recording.
    pub profile: RecordingProfile,
    /// `true` if the composite's `[deploy] record` takes effect.
    pub follows_composite: bool,
}

/// The recording of a mission that has ended.
#[derive(Clone, Debug, PartialEq)]
pub struct RecordingResult {
    /// The files, in order; several if the recording was divided. Empty if none could be created.
    pub paths: Vec<PathBuf>,
    /// Number of bytes in all files.
    pub bytes: u64,
    /// Number of messages of the run that are not in the files.
    pub lost: u64,
    /// The reason that the recording ended before the run, or did not begin.
    pub failure: Option<String>,
    /// Patterns of ports that published nothing.
    pub unmatched: Vec<String>,
}

impl RecordingResult {
    /// Returns whether every message of the run is in the files.
    pub fn is_complete(&self) -> bool {
        self.lost == 0 && self.failure.is_none()
    }
}

impl RecordingRequest {
    /// Returns whether the steps of the coordinators of a plan are recorded.
    pub(super) fn records_cycles(&self, plan: &Plan) -> bool {
        match (&self.file, &plan.record) {
            _ if !cfg!(feature = "mcap") => false,
            (Some(_), _) => true,
            (None, Some(record)) => self.follows_composite && record.asm_states,
            (None, None) => false,
        }
    }
}

/// A mission, as far as its recording depends on it.
#[allow(
    dead_code,
    reason = "a build reads what it needs: with the feature `mcap` all but `notice`, without it `notice` and `request`"
)]
pub(super) struct RecordedMission<'a> {
    /// Request to record it.
    pub request: &'a RecordingRequest,
    /// `true` if its clock is virtual: equal runs then have equal recordings, and the run waits for a slow disk.
    pub is_virtual: bool,
    /// Seed for the choices of specifications.
    pub seed: u64,
    /// Selected profile.
    pub profile: Option<&'a str>,
    /// Process, if the composite is deployed to several.
    pub process: Option<&'a str>,
    /// Properties set on the command line, each as `name=value`.
    pub settings: Vec<String>,
    /// Receives a warning.
    pub notice: fn(&str),
}
