//! What the laser saw: kept while it is out of sight, dropped when a beam passes through, or with time.

use std::collections::BTreeMap;

use geometry::{Point, Pose};
use messages::LaserScan;

/// m, side of the squares of which each keeps one point.
const SIDE: f64 = 0.05;

/// m, how far behind a remembered point a beam must end to say that the point is gone.
const THROUGH: f64 = 0.15;

/// The points at which beams ended, map frame; at most one in each small square, in a fixed order.
#[derive(Debug, Clone, Default)]
pub struct Memory {
    seen: BTreeMap<(i32, i32), Seen>,
}

/// One remembered point.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Seen {
    /// Map frame, m.
    pub point: Point,
    /// ns, of the newest scan that saw it.
    pub at: i64,
}

impl Memory {
    /// Takes a scan that was made from `laser` at `nanos`: forgets what it looked through, and remembers the hits up
    /// to `sight` metres away that `counts` says yes to.
    pub fn look(&mut self, scan: &LaserScan, laser: &Pose, nanos: i64, sight: f64, counts: impl Fn(Point) -> bool) {
        let back = laser.inverse();
        self.seen.retain(|_, seen| !sees_through(scan, back * seen.point));
        for (angle, range) in scan.hits().filter(|(_, range)| *range <= sight) {
            let point = laser * Point::new(range * angle.cos(), range * angle.sin());
            if counts(point) {
                self.seen.insert(square(point), Seen { point, at: nanos });
            }
        }
    }

    /// Forgets what was not seen since `nanos`.
    pub fn forget_before(&mut self, nanos: i64) {
        self.seen.retain(|_, seen| seen.at >= nanos);
    }

    /// Forgets everything.
    pub fn clear(&mut self) {
        self.seen.clear();
    }

    /// What is remembered, in the order of the squares.
    pub fn points(&self) -> impl Iterator<Item = Point> + '_ {
        self.seen.values().map(|seen| seen.point)
    }

    /// When the newest of it was seen, ns.
    pub fn newest(&self) -> Option<i64> {
        self.seen.values().map(|seen| seen.at).max()
    }
}

fn square(point: Point) -> (i32, i32) {
    ((point.x / SIDE).floor() as i32, (point.y / SIDE).floor() as i32)
}

/// Whether the beams around a point (in the laser's frame) all end well behind it.
fn sees_through(scan: &LaserScan, point: Point) -> bool {
    if scan.angle_increment <= 0.0 {
        return false;
    }
    let bearing = point.y.atan2(point.x);
    let beam = (bearing - f64::from(scan.angle_min)) / f64::from(scan.angle_increment);
    let (before, after) = (beam.floor(), beam.ceil());
    if before < 0.0 || after >= scan.ranges.len() as f64 {
        return false;
    }
    let distance = point.coords.norm();
    // NaN compares false and a beam that ended too near is -Inf: neither says that the way is free
    scan.ranges[before as usize..=after as usize]
        .iter()
        .all(|range| f64::from(*range) > distance + THROUGH)
}
