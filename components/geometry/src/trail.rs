//! Recent poses of the robot, which tell where it was when a scan was taken.

use std::collections::VecDeque;

use crate::pose::{Pose, heading, turn, yaw};
use serde::{Deserialize, Serialize};

/// The most recent poses with their times.
#[derive(Debug, Clone, Default, Serialize, Deserialize)]
pub struct Trail {
    /// (ns, pose), oldest first.
    poses: VecDeque<(i64, Pose)>,
}

/// Number of poses kept: more than a second at 50 Hz.
const KEPT: usize = 64;

/// Time in ns before or after the known poses for which the nearest one is still used.
const TOLERANCE: i64 = 200_000_000;

impl Trail {
    /// Adds the robot's pose at `nanos`, map frame. A pose that is older than the newest, or not finite, is ignored.
    pub fn add(&mut self, nanos: i64, pose: Pose) {
        let late = self.poses.back().is_some_and(|(last, _)| *last >= nanos);
        if late || !is_somewhere(&pose) {
            return;
        }
        if self.poses.len() == KEPT {
            self.poses.pop_front();
        }
        self.poses.push_back((nanos, pose));
    }

    /// Newest pose, map frame; `None` before the first odometry.
    pub fn newest(&self) -> Option<&Pose> {
        self.poses.back().map(|(_, pose)| pose)
    }

    /// Pose of the robot at `nanos`, interpolated linearly between two known poses; `None` outside the trail and its
    /// tolerance.
    pub fn at(&self, nanos: i64) -> Option<Pose> {
        let after = self.poses.partition_point(|(at, _)| *at <= nanos);
        let (before, after) = (
            after.checked_sub(1).and_then(|at| self.poses.get(at)),
            self.poses.get(after),
        );
        match (before, after) {
            (Some((from, a)), Some((to, b))) => {
                let share = (nanos - from) as f64 / (to - from) as f64;
                let place = a.translation.vector.lerp(&b.translation.vector, share);
                let heading_there = yaw(a) + share * turn(yaw(a), yaw(b));
                Some(heading(place.into(), heading_there))
            }
            (Some((at, pose)), None) | (None, Some((at, pose))) => {
                ((nanos - at).abs() <= TOLERANCE).then_some(*pose)
            }
            (None, None) => None,
        }
    }
}

fn is_somewhere(pose: &Pose) -> bool {
    let place = pose.translation;
    place.x.is_finite() && place.y.is_finite() && yaw(pose).is_finite()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pose::Point;

    fn pose(x: f64, yaw: f64) -> Pose {
        heading(Point::new(x, 0.0), yaw)
    }

    #[test]
    fn it_is_between_what_it_knows() {
        let mut trail = Trail::default();
        trail.add(0, pose(0.0, 3.0));
        trail.add(100, pose(1.0, -3.0));
        let middle = trail.at(50).unwrap();
        assert!((middle.translation.x - 0.5).abs() < 1e-12);
        assert!(yaw(&middle).abs() > 3.1, "the short way round");
    }

    #[test]
    fn it_does_not_reach_far_beyond() {
        let mut trail = Trail::default();
        assert_eq!(trail.at(0), None);
        trail.add(1_000_000_000, pose(1.0, 0.0));
        assert!(trail.at(1_100_000_000).is_some() && trail.at(900_000_000).is_some());
        assert!(trail.at(1_300_000_000).is_none() && trail.at(0).is_none());
    }

    #[test]
    fn it_forgets_what_is_long_ago_and_ignores_what_comes_late() {
        let mut trail = Trail::default();
        for step in 0..1000 {
            trail.add(step * 20_000_000, pose(0.0, 0.0));
        }
        trail.add(0, pose(9.0, 0.0));
        trail.add(i64::MAX, pose(f64::NAN, 0.0));
        trail.add(i64::MAX, pose(0.0, f64::NAN));
        assert_eq!(trail.poses.len(), KEPT);
        assert!(trail.at(5_000_000_000).is_none());
        assert_eq!(trail.newest(), Some(&pose(0.0, 0.0)));
    }
}
