//! Obstacles for the planner that the map does not show, as points of their surfaces.

use asmotion_geometry::Point;
use serde::{Deserialize, Serialize};

use crate::bend_limits::BendLimits;
use crate::cluster::{GAP, clusters};
use crate::route::BendableRoute;

/// Selects the points of the obstacles on the path: for a robot without a map. The planner did not know these obstacles,
/// because its path leads through them; it may know all others.
pub fn obstacles_on_path(
    points: impl Iterator<Item = Point>,
    route: &BendableRoute,
    limits: &BendLimits,
) -> Vec<Point> {
    let off = |point: &Point| route.distance(*point);
    let nearby: Vec<Point> = points
        .filter(|point| off(point) <= limits.reach_m)
        .collect();
    let is_on_path =
        |cluster: &Vec<Point>| cluster.iter().any(|point| off(point) < limits.clearance());
    clusters(&nearby)
        .into_iter()
        .filter(is_on_path)
        .flatten()
        .collect()
}

/// Obstacles that have recently blocked a path, so that a robot without a map does not alternate between two blocked
/// paths.
#[derive(Debug, Clone, Default, Serialize, Deserialize)]
pub struct Blockers {
    /// Each point with the time at which its obstacle last blocked a path, ns.
    points: Vec<(Point, i64)>,
}

impl Blockers {
    /// Adds points of obstacles that block a path at `now`; they replace the remembered points that they are connected to.
    pub fn add(&mut self, points: &[Point], now: i64) {
        let joins = |a: &Point, b: &Point| (a - b).norm_squared() < GAP * GAP;
        self.points
            .retain(|(old, _)| !points.iter().any(|new| joins(old, new)));
        self.points.extend(points.iter().map(|point| (*point, now)));
    }

    /// Forgets obstacles that have not blocked a path since `nanos`. Returns whether there were any.
    pub fn forget_before(&mut self, nanos: i64) -> bool {
        let before = self.points.len();
        self.points.retain(|(_, at)| *at >= nanos);
        self.points.len() != before
    }

    /// The remembered points, map frame.
    pub fn points(&self) -> Vec<Point> {
        self.points.iter().map(|(point, _)| *point).collect()
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
        let hits = reported(&[beside, on_it.clone()].concat());
        assert_eq!(hits, on_it[..3], "not what stands 0.9 m behind it");
    }

    #[test]
    fn what_blocked_is_remembered_for_a_while_and_renewed() {
        let at = |x: f64| Point::new(x, 0.0);
        let mut blockers = Blockers::default();
        blockers.add(&[at(0.0), at(0.3)], 0);
        blockers.add(&[at(5.0)], 10);
        blockers.add(&[at(0.1)], 20);
        assert_eq!(blockers.points(), [at(0.3), at(5.0), at(0.1)]);
        assert!(blockers.forget_before(10));
        assert!(!blockers.forget_before(10));
        assert!(blockers.forget_before(11));
        assert_eq!(blockers.points(), [at(0.1)]);
    }
}
