//! The path that something drives, by its odometry.

use asmotion_component::Time;
use asmotion_datum::Sample;
use asmotion_messages::{Odometry, Point, PoseStamped};

use super::StoryEntry;
use crate::terminal::FAINT;

/// Interval between reports of progress, in seconds of the run.
const PROGRESS_S: f64 = 5.0;

/// Progress in m since the last report below which it counts as standing.
const STANDS: f64 = 0.1;

/// A driven path and its goal.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct DrivenPath {
    /// Distance driven, m.
    pub driven_m: f64,
    /// The newest goal.
    pub(super) goal: Option<Point>,
    at: Option<Point>,
    /// Time of the last report of progress, and the distance driven by then.
    last_report: (f64, f64),
}

impl DrivenPath {
    /// The position in an odometry message; `None` for other messages.
    pub(super) fn position(sample: &dyn Sample) -> Option<Point> {
        let odometry = sample.downcast_ref::<Odometry>()?;
        Some(odometry.pose.pose.position)
    }

    /// The position in a goal message; `None` for other messages.
    pub(super) fn goal(sample: &dyn Sample) -> Option<Point> {
        let goal = sample.to_shared().read::<PoseStamped>().ok()?;
        let is_pose = sample.type_name() == <PoseStamped as asmotion_datum::Message>::NAME;
        is_pose.then_some(goal.pose.position)
    }

    /// Distance to the newest goal, m; `None` without a goal or a position.
    pub fn to_goal_m(&self) -> Option<f64> {
        Some(distance(&self.goal?, &self.at?))
    }

    /// Adds a position. Returns a report of progress from time to time.
    pub(super) fn moved(&mut self, at: Time, to: Point) -> Option<StoryEntry> {
        if let Some(from) = self.at.replace(to) {
            self.driven_m += distance(&from, &to);
        }
        let remaining = self.to_goal_m()?;
        let (then, driven) = self.last_report;
        if at.seconds() - then < PROGRESS_S || self.driven_m - driven < STANDS {
            return None;
        }
        self.last_report = (at.seconds(), self.driven_m);
        Some(StoryEntry::single(format!(
            "{FAINT}at ({:.1}, {:.1}), {remaining:.1} m from the goal{FAINT:#}",
            to.x, to.y
        )))
    }
}

fn distance(one: &Point, other: &Point) -> f64 {
    (one.x - other.x).hypot(one.y - other.y)
}
