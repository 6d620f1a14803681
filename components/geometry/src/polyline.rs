//! Polylines: length, position along the line, direction.

use serde::{Deserialize, Serialize};

use crate::pose::{Point, Pose, Vector, heading};

/// A line through points, with precomputed distances.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(from = "Vec<Point>", into = "Vec<Point>")]
pub struct Polyline {
    points: Vec<Point>,
    /// Distance of each point along the line, m.
    along: Vec<f64>,
}

/// The point on a polyline that is nearest to a query point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NearestOnLine {
    /// Position on the line.
    pub point: Point,
    /// Distance from the query point, m.
    pub distance: f64,
    /// Distance along the line, m.
    pub along: f64,
    /// Index of the segment, which leads from point `segment` to the next.
    pub segment: usize,
}

impl From<Vec<Point>> for Polyline {
    fn from(points: Vec<Point>) -> Self {
        Self::new(points)
    }
}

impl From<Polyline> for Vec<Point> {
    fn from(line: Polyline) -> Self {
        line.points
    }
}

impl Polyline {
    /// Creates the line through `points` in order; points that repeat their predecessor or are not finite are left out.
    pub fn new(points: impl IntoIterator<Item = Point>) -> Self {
        let mut line = Self::default();
        for point in points {
            let step = line.points.last().map_or(0.0, |last| (point - last).norm());
            let finite = point.coords.iter().all(|value| value.is_finite());
            if finite && (step > 0.0 || line.points.is_empty()) {
                line.along.push(line.length() + step);
                line.points.push(point);
            }
        }
        line
    }

    /// The points without the omitted ones.
    pub fn points(&self) -> &[Point] {
        &self.points
    }

    /// Returns whether there are no points.
    pub fn is_empty(&self) -> bool {
        self.points.is_empty()
    }

    /// Length of the line, m.
    pub fn length(&self) -> f64 {
        self.along.last().copied().unwrap_or(0.0)
    }

    /// The pose `along` metres from the start, in the direction of the line; the ends are used beyond them. `None` for
    /// a line without points; a single point has the direction of x.
    pub fn at(&self, along: f64) -> Option<Pose> {
        let first = self.points.first()?;
        let Some(last) = self.points.len().checked_sub(2) else {
            return Some(heading(*first, 0.0));
        };
        let after = self.along.partition_point(|at| *at <= along);
        let segment = after.saturating_sub(1).min(last);
        let (way, length) = self.segment(segment);
        let step = (along - self.along[segment]).clamp(0.0, length);
        let point = self.points[segment] + way * (step / length);
        Some(heading(point, way.y.atan2(way.x)))
    }

    /// The nearest point of the line to `point`; the first of several. `None` for a line without points.
    pub fn nearest(&self, point: Point) -> Option<NearestOnLine> {
        self.nearest_between(point, 0.0, f64::INFINITY)
    }

    /// The nearest point to `point` between `from` and `to` metres along the line, so that a follower does not jump to
    /// another lap. `None` for a line without points.
    pub fn nearest_between(&self, point: Point, from: f64, to: f64) -> Option<NearestOnLine> {
        let end = self.length();
        let (from, to) = (from.clamp(0.0, end), to.clamp(0.0, end));
        let first = self.points.first()?;
        if self.points.len() == 1 {
            return Some(self.place(point, 0, *first, 0.0));
        }
        let segments = 0..self.points.len() - 1;
        let in_range = segments.filter(|at| self.along[*at] <= to && self.along[at + 1] >= from);
        let places = in_range.map(|at| {
            let (way, length) = self.segment(at);
            let foot = (point - self.points[at]).dot(&way) / length;
            let low = (from - self.along[at]).clamp(0.0, length);
            let high = (to - self.along[at]).clamp(low, length);
            let step = foot.clamp(low, high);
            let place = self.points[at] + way * (step / length);
            self.place(point, at, place, step)
        });
        places.reduce(|best, place| {
            if place.distance < best.distance {
                place
            } else {
                best
            }
        })
    }

    /// The line as poses that are at most `step` metres apart and have its direction. All points of the line are kept,
    /// so the poses never leave it; a corner has the direction of the following segment. If `step` is not positive, no
    /// poses are added.
    pub fn resampled(&self, step: f64) -> Vec<Pose> {
        let mut poses = Vec::new();
        for segment in 0..self.points.len().saturating_sub(1) {
            let (way, length) = self.segment(segment);
            let pieces = if step > 0.0 {
                (length / step - 1e-9).ceil().max(1.0)
            } else {
                1.0
            };
            let yaw = way.y.atan2(way.x);
            poses.extend(
                (0..pieces as u32)
                    .map(|piece| self.points[segment] + way * (f64::from(piece) / pieces))
                    .map(|point| heading(point, yaw)),
            );
        }
        poses.extend(self.at(f64::INFINITY));
        poses
    }

    fn place(&self, asked: Point, segment: usize, point: Point, step: f64) -> NearestOnLine {
        NearestOnLine {
            point,
            distance: (asked - point).norm(),
            along: self.along[segment] + step,
            segment,
        }
    }

    fn segment(&self, segment: usize) -> (Vector, f64) {
        let way = self.points[segment + 1] - self.points[segment];
        (way, self.along[segment + 1] - self.along[segment])
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pose::yaw;
    use std::f64::consts::FRAC_PI_2;

    fn corner() -> Polyline {
        Polyline::new(
            [(0.0, 0.0), (4.0, 0.0), (4.0, 0.0), (4.0, 3.0)].map(|(x, y)| Point::new(x, y)),
        )
    }

    #[test]
    fn it_measures_itself_once_for_repeated_points() {
        assert_eq!((corner().length(), corner().points().len()), (7.0, 3));
    }

    #[test]
    fn it_looks_along_itself() {
        let pose = corner().at(5.0).unwrap();
        assert_eq!(Point::from(pose.translation.vector), Point::new(4.0, 1.0));
        assert!((yaw(&pose) - FRAC_PI_2).abs() < 1e-12);
        assert!(yaw(&corner().at(-1.0).unwrap()).abs() < 1e-12);
        assert!((corner().at(99.0).unwrap().translation.y - 3.0).abs() < 1e-12);
    }

    #[test]
    fn it_finds_the_nearest_place() {
        let nearest = corner().nearest(Point::new(3.0, 1.0)).unwrap();
        assert_eq!(
            (nearest.along, nearest.distance, nearest.segment),
            (3.0, 1.0, 0)
        );
        let later = corner()
            .nearest_between(Point::new(3.0, 0.5), 4.0, 7.0)
            .unwrap();
        assert_eq!((later.along, later.distance), (4.5, 1.0));
        assert_eq!(Polyline::default().nearest(Point::origin()), None);
    }

    #[test]
    fn it_resamples_without_cutting_corners() {
        let poses = corner().resampled(0.9);
        assert!(
            poses
                .iter()
                .any(|pose| pose.translation.vector == Vector::new(4.0, 0.0))
        );
        assert_eq!(poses.len(), 5 + 4 + 1);
        let line = Polyline::new(
            poses
                .iter()
                .map(|pose| Point::from(pose.translation.vector)),
        );
        assert!((line.length() - 7.0).abs() < 1e-9);
    }

    #[test]
    fn a_point_is_a_line_too() {
        let dot = Polyline::new([Point::new(1.0, 2.0)]);
        assert_eq!(dot.resampled(0.1).len(), 1);
        assert_eq!(dot.nearest(Point::new(1.0, 0.0)).unwrap().distance, 2.0);
        assert_eq!(Polyline::new([Point::new(f64::NAN, 0.0)]).at(0.0), None);
    }
}
