//! Freezing and thawing of the state of a port-proxy.

use std::collections::VecDeque;

use asmotion_component::{CannotFreeze, FrozenState, ThawError, ThawProblem, Time};
use asmotion_datum::Datum;
use serde::{Deserialize, Serialize};

use super::PortProxy;
use super::lengths::LearntLength;
use super::motion::MotionMonitor;
use super::operation::Waiting;

/// Component type named in frozen states.
const COMPONENT: &str = "port-proxy";

/// Layout version of [`FrozenProxy`].
const VERSION: u32 = 2;

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct FrozenProxy {
    /// Per operation, in the order of the mapping: messages not yet read and pending callers.
    operations: Vec<(VecDeque<Datum>, Vec<Waiting>)>,
    /// `None` if no motion is monitored.
    motion: Option<FrozenMotion>,
    /// `true` between an event `stale` and the next sample; `None` if silence is not monitored.
    is_stale: Option<bool>,
    received_at: Option<Time>,
    /// Per list of commands with a known length, in the order of the settings.
    lengths: Vec<LearntLength>,
    /// Number of commands that were refused without a caller who waits, or after they had been sent.
    refused: u64,
    /// Reasons of these that have been reported.
    reported: Vec<String>,
}

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct FrozenMotion {
    goal: Option<Vec<f64>>,
    near_since: Option<Time>,
}

impl FrozenMotion {
    fn of(motion: &MotionMonitor) -> Self {
        Self {
            goal: motion.goal.clone(),
            near_since: motion.near_since,
        }
    }
}

impl PortProxy {
    pub(super) fn frozen(&self) -> Result<FrozenState, CannotFreeze> {
        let operations = self.operations.iter();
        let frozen = FrozenProxy {
            operations: operations
                .map(|of| (of.samples.clone(), of.waiting.clone()))
                .collect(),
            motion: self.motion.as_ref().map(FrozenMotion::of),
            is_stale: self.events.as_ref().map(|events| events.is_stale),
            received_at: self.received_at,
            lengths: self.lengths.learnt(),
            refused: self.refused.count,
            reported: self.refused.reported.clone(),
        };
        FrozenState::of(COMPONENT, VERSION, &frozen)
    }

    /// Restores a state; on error the proxy is unchanged.
    pub(super) fn thawed(&mut self, state: &FrozenState) -> Result<(), ThawError> {
        let frozen: FrozenProxy = state.read(COMPONENT, VERSION)?;
        let fits = frozen.operations.len() == self.operations.len()
            && frozen.motion.is_some() == self.motion.is_some()
            && frozen.is_stale.is_some() == self.events.is_some();
        // last, since it restores the lengths if they fit
        if !fits || !self.lengths.restore(&frozen.lengths) {
            let what = "it is the state of a proxy with a different map".to_owned();
            return Err(ThawError {
                component: COMPONENT.to_owned(),
                problem: ThawProblem::Foreign(what),
            });
        }
        for (of, (kept, waiting)) in self.operations.iter_mut().zip(frozen.operations) {
            of.samples = kept;
            of.waiting = waiting;
        }
        if let (Some(motion), Some(frozen)) = (&mut self.motion, frozen.motion) {
            motion.goal = frozen.goal;
            motion.near_since = frozen.near_since;
        }
        if let (Some(events), Some(is_stale)) = (&mut self.events, frozen.is_stale) {
            events.is_stale = is_stale;
        }
        self.received_at = frozen.received_at;
        self.refused.count = frozen.refused;
        self.refused.reported = frozen.reported;
        Ok(())
    }
}
