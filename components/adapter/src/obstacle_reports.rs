//! Obstacles for the planner that the map does not show, as discs.

use asmotion_geometry::{Point, RoundObstacle};
use serde::{Deserialize, Serialize};

use crate::bend_limits::BendLimits;
use crate::cluster::{clusters, cover};
use crate::route::BendableRoute;

/// Largest radius in m of the discs that cover an obstacle.
const COVER: f64 = 0.25;

/// Covers all points with discs: for a robot with a map, which remembers only points that the map does not show.
pub fn all_obstacles(points: &[Point]) -> Vec<RoundObstacle> {
    let mut discs = Vec::new();
    for cluster in clusters(points) {
        cover(cluster, COVER, &mut discs);
    }
    discs
}

/// Covers the obstacles on the path with discs: for a robot without a map. The planner did not know these obstacles,
/// because its path leads through them; it may know all others.
pub fn obstacles_on_path(
    points: impl Iterator<Item = Point>,
    route: &BendableRoute,
    limits: &BendLimits,
) -> Vec<RoundObstacle> {
    let off = |point: &Point| route.distance(*point);
    let nearby: Vec<Point> = points
        .filter(|point| off(point) <= limits.reach_m)
        .collect();
    let mut discs = Vec::new();
    for cluster in clusters(&nearby) {
        if cluster.iter().any(|point| off(point) < limits.clearance()) {
            cover(cluster, COVER, &mut discs);
        }
    }
    discs
}

/// Obstacles that have recently blocked a path, so that a robot without a map does not alternate between two blocked
/// paths.
#[derive(Debug, Clone, Default, Serialize, Deserialize)]
pub struct Blockers {
    /// Each disc with the time at which it last blocked a path, ns.
    discs: Vec<(RoundObstacle, i64)>,
}

impl Blockers {
    /// Adds obstacles that block a path at `now`; they replace remembered ones that they overlap.
    pub fn add(&mut self, discs: &[RoundObstacle], now: i64) {
        let overlap = |a: &RoundObstacle, b: &RoundObstacle| {
            (a.centre - b.centre).norm() < a.radius + b.radius
        };
        self.discs
            .retain(|(old, _)| !discs.iter().any(|new| overlap(old, new)));
        self.discs.extend(discs.iter().map(|disc| (*disc, now)));
    }

    /// Forgets discs that have not blocked a path since `nanos`. Returns whether there were any.
    pub fn forget_before(&mut self, nanos: i64) -> bool {
        let before = self.discs.len();
        self.discs.retain(|(_, at)| *at >= nanos);
        self.discs.len() != before
    }

    /// The remembered discs, map frame.
    pub fn discs(&self) -> Vec<RoundObstacle> {
        self.discs.iter().map(|(disc, _)| *disc).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bend::tests::LIMITS;
    use asmotion_messages::{Path, Pose};

    fn points(all: &[(f64, f64)]) -> Vec<Point> {
        all.iter().map(|(x, y)| Point::new(*x, *y)).collect()
    }

    #[test]
    fn without_a_map_it_is_what_stands_on_the_path() {
        let ends = [Pose::planar(0.0, 0.0, 0.0), Pose::planar(8.0, 0.0, 0.0)];
        let route = BendableRoute::new(Path::from_poses(1, "map", ends)).unwrap();
        let beside = points(&[(1.0, 0.9), (1.1, 0.9)]);
        let on_it = points(&[(3.0, 0.2), (3.0, 0.3), (3.0, 0.4), (3.0, 1.3)]);
        let reported =
            |points: &[Point]| obstacles_on_path(points.iter().copied(), &route, &LIMITS);
        assert_eq!(reported(&beside), []);
        let discs = reported(&[beside, on_it].concat());
        assert_eq!(discs.len(), 1);
        assert!((discs[0].centre - Point::new(3.0, 0.3)).norm() < 1e-9);
    }

    #[test]
    fn with_a_map_it_is_everything() {
        assert_eq!(all_obstacles(&points(&[(1.0, 9.0), (5.0, 5.0)])).len(), 2);
    }

    #[test]
    fn what_blocked_is_remembered_for_a_while_and_renewed() {
        let disc = |x: f64| RoundObstacle {
            centre: Point::new(x, 0.0),
            radius: 0.2,
        };
        let mut blockers = Blockers::default();
        blockers.add(&[disc(0.0)], 0);
        blockers.add(&[disc(5.0)], 10);
        blockers.add(&[disc(0.1)], 20);
        assert_eq!(blockers.discs(), [disc(5.0), disc(0.1)]);
        assert!(!blockers.forget_before(10));
        assert!(blockers.forget_before(11));
        assert_eq!(blockers.discs(), [disc(0.1)]);
    }
}
