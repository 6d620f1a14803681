//! Points seen by the laser: remembered while out of sight, dropped when a beam passes through them or after a time.

use std::collections::BTreeMap;

use asmotion_geometry::{Point, Pose};
use asmotion_messages::LaserScan;
use serde::{Deserialize, Serialize};

/// m, side of the squares of which each keeps one point.
const SIDE: f64 = 0.05;

/// m, distance behind a remembered point at which a beam must end for the point to be dropped.
const THROUGH: f64 = 0.15;

/// End points of beams, map frame; at most one for each square, in a fixed order.
#[derive(Debug, Clone, Default, Serialize, Deserialize)]
#[serde(from = "Vec<RememberedPoint>", into = "Vec<RememberedPoint>")]
pub struct ScanMemory {
    seen: BTreeMap<(i32, i32), RememberedPoint>,
}

/// A remembered point.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct RememberedPoint {
    /// Position, map frame, m.
    pub point: Point,
    /// Stamp of the newest scan that saw it, ns.
    pub at: i64,
}

impl From<Vec<RememberedPoint>> for ScanMemory {
    fn from(seen: Vec<RememberedPoint>) -> Self {
        let by_square = seen.into_iter().map(|seen| (square(seen.point), seen));
        Self {
            seen: by_square.collect(),
        }
    }
}

impl From<ScanMemory> for Vec<RememberedPoint> {
    fn from(memory: ScanMemory) -> Self {
        memory.seen.into_values().collect()
    }
}

impl ScanMemory {
    /// Adds a scan taken from `laser` (map frame) at `nanos`: forgets points that beams passed through, and remembers
    /// the hits within `sight` metres that `counts` accepts.
    pub fn update(
        &mut self,
        scan: &LaserScan,
        laser: &Pose,
        nanos: i64,
        sight: f64,
        counts: impl Fn(Point) -> bool,
    ) {
        let back = laser.inverse();
        self.seen
            .retain(|_, seen| !sees_through(scan, back * seen.point));
        for (angle, range) in scan.hits().filter(|(_, range)| *range <= sight) {
            let point = laser * Point::new(range * angle.cos(), range * angle.sin());
            if counts(point) {
                self.seen
                    .insert(square(point), RememberedPoint { point, at: nanos });
            }
        }
    }

    /// Forgets the points under a robot of this radius (m), which stands where they were. Points near its rim are kept: the
    /// robot may touch them.
    pub fn forget_under(&mut self, robot: Point, radius: f64) {
        let under = |point: Point| (point - robot).norm() < radius - SIDE;
        self.seen.retain(|_, seen| !under(seen.point));
    }

    /// Forgets points not seen since `nanos`.
    pub fn forget_before(&mut self, nanos: i64) {
        self.seen.retain(|_, seen| seen.at >= nanos);
    }

    /// Forgets everything.
    pub fn clear(&mut self) {
        self.seen.clear();
    }

    /// The remembered points, map frame, in the order of their squares.
    pub fn points(&self) -> impl Iterator<Item = Point> + '_ {
        self.seen.values().map(|seen| seen.point)
    }
}

fn square(point: Point) -> (i32, i32) {
    (
        (point.x / SIDE).floor() as i32,
        (point.y / SIDE).floor() as i32,
    )
}

/// Returns whether the beams on both sides of a point (laser frame) end well behind it.
fn sees_through(scan: &LaserScan, point: Point) -> bool {
    if scan.angle_increment <= 0.0 {
        return false;
    }
    let bearing = point.y.atan2(point.x);
    let beam = (bearing - f64::from(scan.angle_min)) / f64::from(scan.angle_increment);
    let (before, after) = (beam.floor(), beam.ceil());
    let in_view = before >= 0.0 && after < scan.ranges.len() as f64;
    if !in_view {
        return false; // a bearing that is not finite shows nothing either
    }
    let distance = point.coords.norm();
    // NaN compares false, and a beam that ended too near is -Inf: neither shows that the way is free
    scan.ranges[before as usize..=after as usize]
        .iter()
        .all(|range| f64::from(*range) > distance + THROUGH)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f32::consts::PI;

    /// A full sweep with the same range everywhere.
    fn round(range: f32) -> LaserScan {
        LaserScan {
            angle_min: -PI,
            angle_max: PI,
            angle_increment: 2.0 * PI / 360.0,
            range_min: 0.1,
            range_max: 8.0,
            ranges: vec![range; 361],
            ..LaserScan::default()
        }
    }

    fn remembered(scans: &[LaserScan]) -> ScanMemory {
        let mut memory = ScanMemory::default();
        for (at, scan) in (0..).zip(scans) {
            memory.update(scan, &Pose::identity(), at, 6.0, |_| true);
        }
        memory
    }

    #[test]
    fn it_keeps_one_point_a_square() {
        let memory = remembered(&[round(1.0), round(1.0)]);
        let count = memory.points().count();
        assert!(
            (100..200).contains(&count),
            "{count} points on a circle of 6.3 m"
        );
        assert!(
            memory
                .points()
                .all(|point| (point.coords.norm() - 1.0).abs() < 1e-6)
        );
    }

    #[test]
    fn a_beam_that_passes_through_a_point_removes_it() {
        assert_eq!(
            remembered(&[round(1.0), round(f32::INFINITY)])
                .points()
                .count(),
            0
        );
        assert!(
            remembered(&[round(1.0), round(2.0)])
                .points()
                .all(|point| point.coords.norm() > 1.9)
        );
    }

    #[test]
    fn the_robot_stands_where_nothing_is() {
        let mut memory = remembered(&[round(1.0)]);
        let all = memory.points().count();
        memory.forget_under(Point::new(1.2, 0.0), 0.25);
        assert_eq!(memory.points().count(), all, "it touches them");
        memory.forget_under(Point::new(1.1, 0.0), 0.25);
        let left: Vec<Point> = memory.points().collect();
        assert!(left.len() < all);
        assert!(
            left.iter()
                .all(|point| (point - Point::new(1.1, 0.0)).norm() >= 0.2)
        );
    }

    #[test]
    fn no_beam_no_news() {
        for blind in [f32::NAN, f32::NEG_INFINITY, 0.5, 1.1] {
            let memory = remembered(&[round(1.0), round(blind)]);
            let kept = memory
                .points()
                .filter(|point| (point.coords.norm() - 1.0).abs() < 1e-3);
            assert!(kept.count() > 100, "after {blind}");
        }
        let narrow = LaserScan {
            angle_min: -0.1,
            ranges: vec![5.0; 12],
            ..round(0.0)
        };
        let memory = remembered(&[round(1.0), narrow]);
        assert!(
            memory.points().filter(|point| point.x < 0.9).count() > 100,
            "outside of the view"
        );
    }

    #[test]
    fn a_scan_of_nonsense_does_no_harm() {
        let nowhere = Pose::translation(f64::NAN, f64::INFINITY);
        for angle_increment in [f32::NAN, 0.0, -1.0, 1.0] {
            for ranges in [vec![], vec![f32::NAN], vec![1.0; 3]] {
                let scan = LaserScan {
                    angle_increment,
                    ranges,
                    ..round(1.0)
                };
                let mut memory = remembered(&[round(1.0)]);
                memory.update(&scan, &nowhere, 1, 6.0, |_| true);
                memory.update(&scan, &Pose::identity(), 2, 6.0, |_| true);
            }
        }
    }

    #[test]
    fn it_forgets_with_time_and_does_not_remember_what_does_not_count() {
        let mut memory = remembered(&[round(1.0)]);
        memory.forget_before(0);
        assert!(memory.points().count() > 0);
        memory.forget_before(1);
        assert_eq!(memory.points().count(), 0);
        memory.update(&round(7.0), &Pose::identity(), 2, 6.0, |_| true);
        memory.update(&round(3.0), &Pose::identity(), 2, 6.0, |_| false);
        assert_eq!(memory.points().count(), 0);
    }
}
