//! The path that a robot drives, by its odometry, and the true position that a simulator reports.

use asmotion_component::Time;
use asmotion_datum::Sample;
use asmotion_messages::{Odometry, Point, PoseStamped};

use crate::terminal::FAINT;

/// Interval between reports of progress, in seconds of the run.
const PROGRESS_S: f64 = 5.0;

/// Progress in m since the last report below which it counts as standing.
const STANDS: f64 = 0.1;

/// Name of the outputs on which simulators publish the true pose of the robot.
const TRUE_POSE_PORT: &str = "truth";

/// A driven path and its goal.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct DrivenPath {
    /// Distance driven by odometry, m.
    pub driven_m: f64,
    /// The newest goal.
    pub(super) goal: Option<Point>,
    /// The newest position by odometry.
    at: Option<Point>,
    /// The newest true position; `None` without a simulator.
    true_at: Option<Point>,
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

    /// Distance to the newest goal by odometry, m; `None` without a goal or a position.
    pub fn to_goal_m(&self) -> Option<f64> {
        Some(distance(&self.goal?, &self.at?))
    }

    /// True distance to the newest goal, m; `None` without a goal or a simulator.
    pub fn true_to_goal_m(&self) -> Option<f64> {
        Some(distance(&self.goal?, &self.true_at?))
    }

    /// Sets the true position, if it is known.
    pub(super) fn set_true_position(&mut self, position: Option<Point>) {
        self.true_at = position;
    }

    /// Adds a position. Returns a report of progress from time to time.
    pub(super) fn moved(&mut self, at: Time, to: Point) -> Option<String> {
        if let Some(from) = self.at.replace(to) {
            self.driven_m += distance(&from, &to);
        }
        let remaining = self.to_goal_m()?;
        let (then, driven) = self.last_report;
        if at.seconds() - then < PROGRESS_S || self.driven_m - driven < STANDS {
            return None;
        }
        self.last_report = (at.seconds(), self.driven_m);
        Some(format!(
            "{FAINT}at ({:.1}, {:.1}), {remaining:.1} m from the goal{FAINT:#}",
            to.x, to.y
        ))
    }
}

fn distance(one: &Point, other: &Point) -> f64 {
    (one.x - other.x).hypot(one.y - other.y)
}
