//! The way of what moves, by odometry.

use asmotion_component::Time;
use asmotion_datum::Sample;
use asmotion_messages::{Odometry, Point, PoseStamped};

use super::StoryEntry;
use crate::terminal::FAINT;

/// How often progress is told, in seconds of the run.
const PROGRESS_S: f64 = 5.0;

/// What has come no farther since progress was told last stands, m.
const STANDS: f64 = 0.1;

/// A way, and where it shall lead.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct DrivenPath {
    /// Metres driven.
    pub driven_m: f64,
    /// The last goal.
    pub(super) goal: Option<Point>,
    at: Option<Point>,
    /// When progress was told last, and how far it was then.
    told: (f64, f64),
}

impl DrivenPath {
    /// Where something is, if a message says it.
    pub(super) fn place(sample: &dyn Sample) -> Option<Point> {
        let odometry = sample.downcast_ref::<Odometry>()?;
        Some(odometry.pose.pose.position)
    }

    /// Where something shall be, if a message says it.
    pub(super) fn goal(sample: &dyn Sample) -> Option<Point> {
        let goal = sample.to_shared().read::<PoseStamped>().ok()?;
        let is_pose = sample.type_name() == <PoseStamped as asmotion_datum::Message>::NAME;
        is_pose.then_some(goal.pose.position)
    }

    /// Metres from the last goal.
    pub fn to_goal_m(&self) -> Option<f64> {
        Some(distance(&self.goal?, &self.at?))
    }

    /// It is there now; progress, from time to time.
    pub(super) fn moved(&mut self, at: Time, to: Point) -> Option<StoryEntry> {
        if let Some(from) = self.at.replace(to) {
            self.driven_m += distance(&from, &to);
        }
        let left = self.to_goal_m()?;
        let (then, driven) = self.told;
        if at.seconds() - then < PROGRESS_S || self.driven_m - driven < STANDS {
            return None;
        }
        self.told = (at.seconds(), self.driven_m);
        Some(StoryEntry::once(format!(
            "{FAINT}at ({:.1}, {:.1}), {left:.1} m from the goal{FAINT:#}",
            to.x, to.y
        )))
    }
}

fn distance(one: &Point, other: &Point) -> f64 {
    (one.x - other.x).hypot(one.y - other.y)
}
