//! The planned path as a road: stations along it, and at each station how far the robot shall keep to the left.

use geometry::{Point, Polyline, Pose, Vector, heading, message};
use messages::{Path, PoseStamped};

/// m, the stations are at most this far apart.
pub const STEP: f64 = 0.1;

/// No road has more stations; on a path longer than ten kilometres they are farther apart.
const MOST: f64 = 1e5;

/// m, half of the stretch whose chord is the direction of the road at a station: corners are rounded a little.
const CHORD: f64 = 0.15;

/// m, how far from its last place along the road the robot is looked for: back, ahead.
const SEARCH: (f64, f64) = (1.0, 1.5);

/// A place on the planned path.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Station {
    /// On the path, map frame, m.
    pub point: Point,
    /// One metre to the left.
    pub left: Vector,
}

/// The path as it was planned, and how it is bent.
#[derive(Debug, Clone)]
pub struct Route {
    planned: Path,
    line: Polyline,
    /// m, from station to station.
    step: f64,
    stations: Vec<Station>,
    /// m to the left of each station.
    offsets: Vec<f64>,
    /// m along the planned path where the robot was last; none before the first look.
    progress: Option<f64>,
}

impl Route {
    /// The road along a path, not bent; none for a path without a usable pose.
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

    /// m, from station to station; 0 for a path that is a point.
    pub fn step(&self) -> f64 {
        self.step
    }

    /// The stations, from the start to the goal.
    pub fn stations(&self) -> &[Station] {
        &self.stations
    }

    /// How far to the left of each station the path is bent, m.
    pub fn offsets(&self) -> &[f64] {
        &self.offsets
    }

    /// Whether any station from `from` on is off the planned path.
    pub fn is_bent(&self, from: usize) -> bool {
        self.offsets.iter().skip(from).any(|offset| *offset != 0.0)
    }

    /// Bends the road from station `from` on; beyond the given offsets it is as planned.
    pub fn bend(&mut self, from: usize, offsets: &[f64]) {
        let beyond = offsets.iter().copied().chain(std::iter::repeat(0.0));
        for (offset, new) in self.offsets.iter_mut().skip(from).zip(beyond) {
            *offset = new;
        }
    }

    /// The last station that is not ahead of a robot at `pose`, and how far to the left of it the robot is, m.
    pub fn locate(&mut self, pose: &Pose) -> (usize, f64) {
        let here = Point::from(pose.translation.vector);
        let (from, to) = match self.progress {
            Some(progress) => (progress - SEARCH.0, progress + SEARCH.1),
            None => (0.0, f64::INFINITY),
        };
        let along = self
            .line
            .nearest_between(here, from, to)
            .map_or(0.0, |nearest| nearest.along);
        self.progress = Some(along);
        let last = self.stations.len() - 1;
        let at = match self.step > 0.0 {
            true => ((along / self.step) as usize).min(last),
            false => last,
        };
        let station = &self.stations[at];
        (at, (here - station.point).dot(&station.left))
    }

    /// m from a point to the planned path.
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
