//! The planned path as a road: stations along it, and the offset to the left at each station.

use asmotion_geometry::{NearestOnLine, Point, Polyline, Pose, Vector, heading, message};
use asmotion_messages::{Path, PoseStamped};
use serde::{Deserialize, Serialize};

use crate::bend_limits::BendLimits;

/// Largest distance between two stations, m.
pub const STEP: f64 = 0.1;

/// Limit on the number of stations; on paths longer than ten kilometres they are farther apart.
const MOST: f64 = 1e5;

/// Half the length in m of the chord that defines the direction at a station, which rounds corners slightly.
const CHORD: f64 = 0.15;

/// Range along the road in which the robot is searched for, in m behind and ahead of its last position.
const SEARCH: (f64, f64) = (1.0, 1.5);

/// A station on the planned path.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Station {
    /// Position, map frame, m.
    pub point: Point,
    /// Unit vector to the left of the path.
    pub left: Vector,
}

/// The planned path and its bend.
#[derive(Debug, Clone, Serialize, Deserialize)]
#[serde(try_from = "FrozenRoute")]
pub struct BendableRoute {
    planned: Path,
    #[serde(skip_serializing)]
    line: Polyline,
    /// Distance between two stations, m.
    #[serde(skip_serializing)]
    step: f64,
    #[serde(skip_serializing)]
    stations: Vec<Station>,
    /// Offset to the left at each station, m.
    offsets: Vec<f64>,
    /// Last position of the robot along the planned path, m; `None` before the first look.
    progress: Option<f64>,
}

/// Serialised form of a route; the line and the stations are derived from the planned path.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct FrozenRoute {
    planned: Path,
    offsets: Vec<f64>,
    progress: Option<f64>,
}

impl TryFrom<FrozenRoute> for BendableRoute {
    type Error = &'static str;

    fn try_from(frozen: FrozenRoute) -> Result<Self, &'static str> {
        let route = Self::new(frozen.planned).ok_or("the path has no usable pose")?;
        if frozen.offsets.len() != route.stations.len() {
            return Err("an offset is wanted for each station");
        }
        Ok(Self {
            offsets: frozen.offsets,
            progress: frozen.progress,
            ..route
        })
    }
}

impl BendableRoute {
    /// Creates the road for a path, without a bend. Returns `None` for a path without a usable pose.
    pub fn new(planned: Path) -> Option<Self> {
        let poses = planned.poses.iter();
        let line = Polyline::new(poses.map(|stamped| message::point(&stamped.pose.position)));
        let pieces = (line.length() / STEP).ceil().clamp(1.0, MOST);
        let step = line.length() / pieces;
        let stations = (0..=pieces as usize)
            .map(|station| Station::on(&line, station as f64 * step))
            .collect::<Option<Vec<_>>>()?;
        Some(Self {
            offsets: vec![0.0; stations.len()],
            planned,
            line,
            step,
            stations,
            progress: None,
        })
    }

    /// The path as it was planned.
    pub fn planned(&self) -> &Path {
        &self.planned
    }

    /// Length of the planned path, m.
    pub fn length(&self) -> f64 {
        self.line.length()
    }

    /// Last position of the robot along the planned path, m; `None` before the first look.
    pub fn progress(&self) -> Option<f64> {
        self.progress
    }

    /// Distance between two stations, m; 0 if the path is a single point.
    pub fn step(&self) -> f64 {
        self.step
    }

    /// The stations, from the start to the goal.
    pub fn stations(&self) -> &[Station] {
        &self.stations
    }

    /// Offset of the path to the left at each station, m.
    pub fn offsets(&self) -> &[f64] {
        &self.offsets
    }

    /// Returns whether any station from `from` on is off the planned path.
    pub fn is_bent(&self, from: usize) -> bool {
        self.offsets.iter().skip(from).any(|offset| *offset != 0.0)
    }

    /// Bends the road from station `from` on. Stations beyond the given offsets return to the plan.
    pub fn bend(&mut self, from: usize, offsets: &[f64]) {
        let beyond = offsets.iter().copied().chain(std::iter::repeat(0.0));
        for (offset, new) in self.offsets.iter_mut().skip(from).zip(beyond) {
            *offset = new;
        }
    }

    /// The last station that is not ahead of a robot at `pose`, and the robot's offset to the left of it, m.
    pub fn locate(&mut self, pose: &Pose) -> (usize, f64) {
        let here = Point::from(pose.translation.vector);
        let along = self.nearest(here).map_or(0.0, |nearest| nearest.along);
        self.progress = Some(along);
        let last = self.stations.len() - 1;
        let at = if self.step > 0.0 {
            ((along / self.step) as usize).min(last)
        } else {
            last
        };
        let station = &self.stations[at];
        (at, (here - station.point).dot(&station.left))
    }

    /// The position of the robot on the path: near its last one; at the beginning, near the start; anywhere only if
    /// that fails.
    fn nearest(&self, here: Point) -> Option<NearestOnLine> {
        if let Some(progress) = self.progress {
            return self
                .line
                .nearest_between(here, progress - SEARCH.0, progress + SEARCH.1);
        }
        let start = self.line.nearest_between(here, 0.0, SEARCH.1)?;
        if start.distance <= SEARCH.0 {
            return Some(start);
        }
        self.line.nearest(here)
    }

    /// Number of stations from `from` on within `horizon` metres.
    pub fn within(&self, from: usize, horizon: f64) -> usize {
        let left = self.stations.len() - from;
        let within = if self.step > 0.0 {
            horizon / self.step
        } else {
            0.0
        };
        left.min(within as usize + 1)
    }

    /// Returns a filter for points that may affect a path within the limits, from station `from` on.
    pub fn around(&self, from: usize, limits: &BendLimits) -> impl Fn(&Point) -> bool + use<> {
        let until = from + self.within(from, limits.horizon_m);
        let points = self.stations[from..until]
            .iter()
            .map(|station| station.point);
        let bounds = points.fold(None, |bounds: Option<(Point, Point)>, point| {
            let (low, high) = bounds.unwrap_or((point, point));
            Some((low.inf(&point), high.sup(&point)))
        });
        let margin = Vector::repeat(limits.reach_m + limits.comfort());
        move |point| {
            bounds.is_some_and(|(low, high)| low - margin <= *point && *point <= high + margin)
        }
    }

    /// Distance from a point to the planned path, m.
    pub fn distance(&self, point: Point) -> f64 {
        self.line
            .nearest(point)
            .map_or(f64::INFINITY, |nearest| nearest.distance)
    }

    /// The point `offset` metres to the left of a station.
    pub fn point(&self, station: usize, offset: f64) -> Point {
        self.stations[station].point + self.stations[station].left * offset
    }

    /// The bent path: header and goal as planned.
    pub fn bent(&self) -> Path {
        let points: Vec<Point> = (0..self.stations.len())
            .map(|station| self.point(station, self.offsets[station]))
            .collect();
        let ways = points.windows(2).map(|pair| (pair[0], pair[1] - pair[0]));
        let poses = ways.map(|(point, way)| heading(point, way.y.atan2(way.x)));
        let stamped = poses.map(|pose| PoseStamped {
            header: self.planned.header.clone(),
            pose: message::pose_message(&pose),
        });
        Path {
            header: self.planned.header.clone(),
            poses: stamped.chain(self.planned.poses.last().cloned()).collect(),
        }
    }
}

impl Station {
    fn on(line: &Polyline, along: f64) -> Option<Self> {
        let here = line.at(along)?;
        let place = |along| line.at(along).map(|pose| pose.translation.vector);
        let chord = place(along + CHORD)? - place(along - CHORD)?;
        let ahead = chord
            .try_normalize(1e-6)
            .unwrap_or(here.rotation * Vector::x());
        Some(Self {
            point: here.translation.vector.into(),
            left: Vector::new(-ahead.y, ahead.x),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use asmotion_geometry::yaw;

    fn path(points: &[(f64, f64)]) -> Path {
        let poses = points
            .iter()
            .map(|(x, y)| asmotion_messages::Pose::planar(*x, *y, 0.5));
        Path::from_poses(7, "map", poses)
    }

    #[test]
    fn it_has_stations_from_start_to_goal() {
        let route = BendableRoute::new(path(&[(0.0, 0.0), (1.05, 0.0)])).unwrap();
        assert_eq!(route.stations().len(), 12);
        assert!(route.step() <= STEP);
        assert_eq!(route.point(0, 0.0), Point::origin());
        assert!((route.point(11, 1.0) - Point::new(1.05, 1.0)).norm() < 1e-9);
    }

    #[test]
    fn it_needs_a_pose_but_one_is_enough() {
        assert!(BendableRoute::new(path(&[])).is_none());
        assert!(BendableRoute::new(path(&[(f64::NAN, 0.0)])).is_none());
        let mut dot = BendableRoute::new(path(&[(1.0, 1.0)])).unwrap();
        assert_eq!(dot.locate(&Pose::identity()).0, dot.stations().len() - 1);
    }

    #[test]
    fn it_finds_the_robot_and_does_not_lose_it_at_a_crossing() {
        // a loop that crosses itself at (2, 0)
        let mut route = BendableRoute::new(path(&[
            (0.0, 0.0),
            (4.0, 0.0),
            (4.0, 2.0),
            (2.0, 2.0),
            (2.0, -2.0),
        ]))
        .unwrap();
        route.locate(&heading(Point::new(1.0, 0.0), 0.0));
        let (station, offset) = route.locate(&heading(Point::new(1.95, 0.3), 0.0));
        assert_eq!(station, 19);
        assert!((offset - 0.3).abs() < 1e-9);
        let (station, _) = route.locate(&heading(Point::new(2.0, -0.01), 0.0));
        assert_eq!(station, 20);
    }

    #[test]
    fn bent_it_keeps_header_and_goal() {
        let planned = path(&[(0.0, 0.0), (1.0, 0.0)]);
        let mut route = BendableRoute::new(planned.clone()).unwrap();
        route.bend(3, &[0.1, 0.2, 0.1]);
        assert!(route.is_bent(5) && !route.is_bent(6));
        let bent = route.bent();
        assert_eq!(
            (&bent.header, bent.poses.last()),
            (&planned.header, planned.poses.last())
        );
        assert!((bent.poses[4].pose.position.y - 0.2).abs() < 1e-12);
        assert!(
            yaw(&message::pose(&bent.poses[3].pose)) > 0.5,
            "it looks along itself"
        );
        route.bend(0, &[]);
        assert!(!route.is_bent(0));
    }
}
