//! The path that a robot drives, by its odometry.

use asmotion_component::Time;
use asmotion_datum::Sample;
use asmotion_messages::{Odometry, Point, PoseStamped};

use crate::style::FAINT;

/// Interval between reports of progress, in seconds of the run.
const PROGRESS_S: f64 = 5.0;

/// Progress in m since the last report below which it counts as standing.
const STANDS: f64 = 0.1;

/// Name of the outputs on which simulators publish the true pose of the robot.
const TRUE_POSE_PORT: &str = "truth";

/// A driven path.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct DrivenPath {
    /// Distance driven by odometry, m.
    pub driven_m: f64,
    /// The newest position by odometry.
    pub(super) at: Option<Point>,
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
        if sample.type_name() != <PoseStamped as asmotion_datum::Message>::NAME {
            return None;
        }
        let goal = sample.to_shared().read::<PoseStamped>().ok()?;
        Some(goal.pose.position)
    }

    /// The true position in a message of a simulator; `None` for other messages.
    pub(super) fn true_position(port: &str, sample: &dyn Sample) -> Option<Point> {
        if port != TRUE_POSE_PORT {
            return None;
        }
        let pose = sample.downcast_ref::<PoseStamped>()?;
        Some(pose.pose.position)
    }

    /// Adds a position. Returns a report of progress from time to time, if there is a goal.
    pub(super) fn moved(
        &mut self,
        at: Time,
        to: Point,
        goal: impl FnOnce() -> Option<Point>,
    ) -> Option<String> {
        if let Some(from) = self.at.replace(to) {
            self.driven_m += distance(&from, &to);
        }
        let (then, driven) = self.last_report;
        if at.seconds() - then < PROGRESS_S || self.driven_m - driven < STANDS {
            return None;
        }
        let remaining = distance(&goal()?, &to);
        self.last_report = (at.seconds(), self.driven_m);
        Some(format!(
            "{FAINT}at ({:.1}, {:.1}), {remaining:.1} m from the goal{FAINT:#}",
            to.x, to.y
        ))
    }
}

/// Distance between two points, m.
pub(super) fn distance(one: &Point, other: &Point) -> f64 {
    (one.x - other.x).hypot(one.y - other.y)
}
