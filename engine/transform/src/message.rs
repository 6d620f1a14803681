//! Stamped messages in another frame.

use std::sync::Arc;

use asmotion_datum::{Datum, Numbers};

use crate::buffer::TransformBuffer;
use crate::cloud;
use crate::failure::{NotTransformable, TransformFailure};
use crate::fields::{change, field_mut, frame_name, nanoseconds, quaternion, text, vector};
use crate::motion::{RigidMotion, Vector3};

/// Takes messages of a type into a frame.
#[derive(Clone, Debug)]
pub struct MessageTransform {
    frame: String,
    parts: &'static [(&'static str, FramedPart)],
}

/// A part of a message that depends on the frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum FramedPart {
    /// `geometry_msgs/Point` or `Point32`.
    Point,
    /// `geometry_msgs/Vector3`: a direction, which is only rotated.
    Vector,
    Quaternion,
    Pose,
    PoseWithCovariance,
    /// `geometry_msgs/PoseStamped` within a message with a header of its own.
    StampedPose,
    /// The whole of a `sensor_msgs/PointCloud2`.
    Cloud,
}

/// The types that can be transformed, with their parts. A twist is not among them: its frame alone does not say at which point it is
/// taken. Nor is a laser scan, whose beams begin at the sensor.
const TYPES: &[(&str, &[(&str, FramedPart)])] = &[
    (
        "geometry_msgs/PointStamped",
        &[("point", FramedPart::Point)],
    ),
    (
        "geometry_msgs/PolygonStamped",
        &[("polygon.points", FramedPart::Point)],
    ),
    ("geometry_msgs/PoseArray", &[("poses", FramedPart::Pose)]),
    ("geometry_msgs/PoseStamped", &[("pose", FramedPart::Pose)]),
    (
        "geometry_msgs/PoseWithCovarianceStamped",
        &[("pose", FramedPart::PoseWithCovariance)],
    ),
    (
        "geometry_msgs/QuaternionStamped",
        &[("quaternion", FramedPart::Quaternion)],
    ),
    (
        "geometry_msgs/Vector3Stamped",
        &[("vector", FramedPart::Vector)],
    ),
    (
        "nav_msgs/Odometry",
        &[("pose", FramedPart::PoseWithCovariance)],
    ),
    ("nav_msgs/Path", &[("poses", FramedPart::StampedPose)]),
    ("sensor_msgs/PointCloud", &[("points", FramedPart::Point)]),
    ("sensor_msgs/PointCloud2", &[("", FramedPart::Cloud)]),
];

impl MessageTransform {
    /// Takes messages of a type of ROS, such as `geometry_msgs/PoseStamped`, into a frame.
    ///
    /// # Errors
    /// [`NotTransformable`].
    pub fn new(kind: &str, frame: &str) -> Result<Self, NotTransformable> {
        let short = kind.replace("/msg/", "/");
        let found = TYPES.iter().find(|(name, _)| *name == short);
        let Some((_, parts)) = found else {
            let kind = kind.to_owned();
            return Err(NotTransformable::Type { kind });
        };
        let is_bad = |sign: char| sign.is_whitespace() || sign.is_control();
        if frame.is_empty() || frame.starts_with('/') || frame.contains(is_bad) {
            let frame = frame.to_owned();
            return Err(NotTransformable::Frame { frame });
        }
        let frame = frame.to_owned();
        Ok(Self { frame, parts })
    }

    /// The types of ROS that can be transformed.
    pub fn types() -> impl Iterator<Item = &'static str> {
        TYPES.iter().map(|(name, _)| *name)
    }

    /// The message in the frame. A message with the stamp 0 takes the latest transform, and its time.
    ///
    /// # Errors
    /// [`TransformFailure`]: there is no transform, at least not yet.
    pub fn apply(
        &self,
        message: &Datum,
        buffer: &TransformBuffer,
    ) -> Result<Datum, TransformFailure> {
        let from = text(message, "header.frame_id").unwrap_or_default();
        let from = frame_name(&from).to_owned();
        if from.is_empty() {
            return Err(TransformFailure::NoFrame);
        }
        let stamp = message.get("header.stamp");
        let stamp = stamp.and_then(|it| nanoseconds(&it)).unwrap_or(0);
        let found = buffer.look_up(&self.frame, &from, stamp)?;
        let mut changed = message.clone();
        for (path, part) in self.parts {
            let mut outcome = Ok(());
            change(&mut changed, path, &mut |value| {
                let result = match part {
                    FramedPart::StampedPose => self.stamped_pose(value, &from, buffer, found.stamp),
                    part @ (FramedPart::Point
                    | FramedPart::Vector
                    | FramedPart::Quaternion
                    | FramedPart::Pose
                    | FramedPart::PoseWithCovariance
                    | FramedPart::Cloud) => part.apply(value, found.motion),
                };
                if outcome.is_ok() {
                    outcome = result;
                }
            });
            outcome?;
        }
        self.write_header(&mut changed, (stamp == 0).then_some(found.stamp));
        Ok(changed)
    }

    /// Transforms an element of a path. All elements are taken at the time of the path: their own can be that of the plan. An
    /// element without a frame has that of the path.
    fn stamped_pose(
        &self,
        value: &mut Datum,
        outer: &str,
        buffer: &TransformBuffer,
        stamp: i64,
    ) -> Result<(), TransformFailure> {
        let own = text(value, "header.frame_id").unwrap_or_default();
        let own = frame_name(&own);
        let from = if own.is_empty() { outer } else { own };
        let found = buffer.look_up(&self.frame, from, stamp)?;
        let mut outcome = Ok(());
        change(value, "pose", &mut |pose| {
            outcome = FramedPart::Pose.apply(pose, found.motion);
        });
        self.write_header(value, None);
        outcome
    }

    fn write_header(&self, message: &mut Datum, stamp: Option<i64>) {
        change(message, "header.frame_id", &mut |value| {
            *value = Datum::text(self.frame.as_str());
        });
        let Some(stamp) = stamp else {
            return;
        };
        change(message, "header.stamp.sec", &mut |value| {
            *value = Datum::Int(stamp.div_euclid(1_000_000_000));
        });
        change(message, "header.stamp.nanosec", &mut |value| {
            *value = Datum::Int(stamp.rem_euclid(1_000_000_000));
        });
    }
}

impl FramedPart {
    fn apply(self, value: &mut Datum, motion: RigidMotion) -> Result<(), TransformFailure> {
        match self {
            Self::Point => set(value, |point| motion.apply(point)),
            Self::Vector => set(value, |vector| motion.rotation.rotate(vector)),
            Self::Quaternion => turn(value, motion),
            Self::Pose | Self::StampedPose => {
                change(value, "position", &mut |it| {
                    set(it, |point| motion.apply(point));
                });
                change(value, "orientation", &mut |it| turn(it, motion));
            }
            Self::PoseWithCovariance => {
                let mut outcome = Ok(());
                change(value, "pose", &mut |pose| {
                    outcome = Self::Pose.apply(pose, motion);
                });
                if let Some(covariance) = field_mut(value, "covariance") {
                    rotate_covariance(covariance, motion);
                }
                return outcome;
            }
            Self::Cloud => return cloud::transform(value, motion),
        }
        Ok(())
    }
}

/// Replaces the coordinates of a point or a vector.
fn set(value: &mut Datum, how: impl Fn(Vector3) -> Vector3) {
    if let Some(found) = vector(value) {
        let Vector3 { x, y, z } = how(found);
        write(value, &[("x", x), ("y", y), ("z", z)]);
    }
}

/// Rotates a quaternion. One without length, which many programs leave in a pose, stays so.
fn turn(value: &mut Datum, motion: RigidMotion) {
    if let Some(found) = quaternion(value) {
        let [x, y, z, w] = motion.rotation.product(found);
        write(value, &[("x", x), ("y", y), ("z", z), ("w", w)]);
    }
}

fn write(value: &mut Datum, numbers: &[(&str, f64)]) {
    for (name, number) in numbers {
        change(value, name, &mut |it| *it = Datum::Float(*number));
    }
}

/// Rotates a covariance of position and rotation, by rows: the covariance of the rotated vectors.
fn rotate_covariance(value: &mut Datum, motion: RigidMotion) {
    const SIZE: usize = 6;
    let number = |index| value.element(index).and_then(|it| it.as_float());
    let known: Option<Vec<f64>> = (0..SIZE * SIZE).map(number).collect();
    let Some(known) = known else {
        return;
    };
    let rows = motion.rotation.rows();
    let rotation = |row: usize, column: usize| {
        let is_same_block = row / 3 == column / 3;
        let found = rows.get(row % 3).and_then(|row| row.get(column % 3));
        found.copied().filter(|_| is_same_block).unwrap_or(0.0)
    };
    let entry = |row: usize, column: usize| known.get(row * SIZE + column).copied().unwrap_or(0.0);
    let sum = |row: usize, column: usize| -> f64 {
        let pairs = (0..SIZE).flat_map(|a| (0..SIZE).map(move |b| (a, b)));
        let terms = pairs.map(|(a, b)| (rotation(row, a) * rotation(column, b), entry(a, b)));
        // an unknown covariance is infinite, and does not spread over a factor of 0
        terms
            .filter(|(factor, _)| *factor != 0.0)
            .map(|(factor, of)| factor * of)
            .sum()
    };
    let rotated = (0..SIZE * SIZE).map(|index| sum(index / SIZE, index % SIZE));
    let rotated: Arc<[f64]> = rotated.collect();
    *value = Datum::Numbers(Numbers::F64(rotated));
}
