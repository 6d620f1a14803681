//! A build without the feature `mcap` records nothing.

use asmotion_component::Time;
use asmotion_plan::{Opened, Plan};
use asmotion_remote::CommandRecord;
use asmotion_runtime::{Run, System};

use super::{RecordedMission, RecordingResult};
use crate::feature::{LeftOut, Mcap};

/// The recording of this build: none.
pub(in crate::mission) struct MissionRecorder;

impl MissionRecorder {
    /// Refuses the recording that the command line asks for, and says that one of the composite has no effect.
    ///
    /// # Errors
    /// The command line asks for a recording.
    pub fn start(
        mission: &RecordedMission<'_>,
        _: &Opened,
        plan: &Plan,
        _: &mut System,
    ) -> Result<Self, String> {
        match &mission.request.file {
            None => {
                if mission.request.follows_composite && plan.record.is_some() {
                    let left_out = LeftOut::new::<Mcap>();
                    (mission.notice)(&format!("`[deploy] record` has no effect: {left_out}"));
                }
                Ok(Self)
            }
            Some(_) => Err(LeftOut::new::<Mcap>().to_string()),
        }
    }

    /// Nothing is recorded.
    pub fn follow(&mut self, _: Time, _: &Opened, _: &Plan) {}

    /// Nothing is recorded.
    pub fn commands(&mut self, _: &[(Time, CommandRecord)]) {}

    /// Nothing is recorded.
    pub fn queues(&mut self, _: &dyn Run) {}

    /// Nothing is recorded.
    pub fn finish(self) -> Option<RecordingResult> {
        None
    }
}
