//! Directors act on a running mission, such as a script of faults.

use asmotion_component::Time;
use asmotion_lang::Report;
use asmotion_plan::Plan;
use asmotion_runtime::Run;

use super::outcome::MissionOutcome;

/// Acts on a running mission at times of its own clock.
pub trait Director {
    /// Prepares for a plan before it starts.
    ///
    /// # Errors
    /// What the director needs and the plan lacks; the mission does not start.
    fn prepare(&mut self, plan: &Plan) -> Result<(), Report>;

    /// Returns whether the director ends the mission; the time limit counts as missed then.
    fn has_goal(&self) -> bool;

    /// Carries out what is due. Returns the outcome if the mission ends.
    fn act(&mut self, run: &mut dyn Run) -> Option<MissionOutcome>;

    /// Ends the observation, before the components are stopped.
    fn finish(&mut self, now: Time);

    /// Time of the next action; `None` if it is not known.
    fn next(&self) -> Option<Time>;

    /// Returns whether something is due at this time.
    fn is_due(&self, now: Time) -> bool;
}

/// The director of a mission that runs by itself.
#[derive(Clone, Copy, Debug, Default)]
pub struct Undirected;

impl Director for Undirected {
    fn prepare(&mut self, _: &Plan) -> Result<(), Report> {
        Ok(())
    }

    fn has_goal(&self) -> bool {
        false
    }

    fn act(&mut self, _: &mut dyn Run) -> Option<MissionOutcome> {
        None
    }

    fn finish(&mut self, _: Time) {}

    fn next(&self) -> Option<Time> {
        None
    }

    fn is_due(&self, _: Time) -> bool {
        false
    }
}
