//! `geometry_msgs`: points, poses, velocities.

use crate::std_msgs::Header;
use asmotion_datum::DatumError;

use crate::plausible::{LARGEST_POSITION, LARGEST_SPEED, bounded, implausible};

asmotion_datum::message! {
    /// A free vector; the unit depends on its use.
    #[derive(Copy)]
    pub struct Vector3 = "geometry_msgs/Vector3", check = check_vector {
        /// Component along the forward axis.
        pub x: f64,
        /// Component along the left axis.
        pub y: f64,
        /// Component along the up axis.
        pub z: f64,
    }

    /// A position in metres.
    #[derive(Copy)]
    pub struct Point = "geometry_msgs/Point", check = check_point {
        /// m, forward.
        pub x: f64,
        /// m, left.
        pub y: f64,
        /// m, up.
        pub z: f64,
    }

    /// An orientation as a unit quaternion.
    #[derive(Copy)]
    pub struct Quaternion = "geometry_msgs/Quaternion", check = check_quaternion {
        /// Sine of half the angle times the axis' x.
        pub x: f64,
        /// Sine of half the angle times the axis' y.
        pub y: f64,
        /// Sine of half the angle times the axis' z.
        pub z: f64,
        /// Cosine of half the angle (default: 1, as in ROS 2: no rotation).
        pub w: f64 = 1.0,
    }

    /// A position and orientation.
    #[derive(Copy)]
    pub struct Pose = "geometry_msgs/Pose" {
        /// Position, m.
        pub position: Point,
        /// Rotation from the frame's axes to the body's.
        pub orientation: Quaternion,
    }

    /// A pose with its time and frame.
    pub struct PoseStamped = "geometry_msgs/PoseStamped" {
        /// Time of the estimate, and frame of the pose.
        pub header: Header,
        /// Position and orientation.
        pub pose: Pose,
    }

    /// A pose with its uncertainty.
    pub struct PoseWithCovariance = "geometry_msgs/PoseWithCovariance" {
        /// Estimated pose.
        pub pose: Pose,
        /// Row-major 6×6 over (x, y, z, roll, pitch, yaw); m², m·rad, rad².
        pub covariance: [f64; 36],
    }

    /// A velocity; in the body's own frame in commands and odometry.
    #[derive(Copy)]
    pub struct Twist = "geometry_msgs/Twist", check = check_twist {
        /// Linear velocity, m/s.
        pub linear: Vector3,
        /// Angular velocity, rad/s.
        pub angular: Vector3,
    }

    /// A velocity with its time and frame.
    pub struct TwistStamped = "geometry_msgs/TwistStamped" {
        /// Time of the estimate, and frame of the velocity.
        pub header: Header,
        /// Linear and angular velocity.
        pub twist: Twist,
    }

    /// A velocity with its uncertainty.
    pub struct TwistWithCovariance = "geometry_msgs/TwistWithCovariance" {
        /// Estimated velocity.
        pub twist: Twist,
        /// Row-major 6×6 over (x, y, z, roll, pitch, yaw); (m/s)², …, (rad/s)².
        pub covariance: [f64; 36],
    }

    /// The transformation from one frame to another.
    #[derive(Copy)]
    pub struct Transform = "geometry_msgs/Transform" {
        /// Translation, m.
        pub translation: Vector3,
        /// Rotation of the child frame.
        pub rotation: Quaternion,
    }

    /// The pose of the frame `child_frame_id` in the frame of the header.
    pub struct TransformStamped = "geometry_msgs/TransformStamped" {
        /// Time of the transformation, and parent frame.
        pub header: Header,
        /// Name of the child frame.
        pub child_frame_id: String,
        /// Pose of the child frame in the parent frame.
        pub transform: Transform,
    }
}

impl Point {
    /// A point on the ground plane, m.
    pub fn planar(x: f64, y: f64) -> Self {
        Self { x, y, z: 0.0 }
    }
}

impl Quaternion {
    /// A rotation by `yaw` radians about the vertical axis, counter-clockwise.
    pub fn from_yaw(yaw: f64) -> Self {
        let (sin, cos) = (yaw / 2.0).sin_cos();
        Self {
            x: 0.0,
            y: 0.0,
            z: sin,
            w: cos,
        }
    }

    /// The rotation about the vertical axis, rad in `-π..=π`; 0 for the all-zero quaternion.
    pub fn yaw(&self) -> f64 {
        let Self { x, y, z, w } = self;
        (2.0 * (w * z + x * y)).atan2(w * w + x * x - y * y - z * z)
    }
}

impl Pose {
    /// A pose in the ground plane: x and y in m, yaw in rad counter-clockwise.
    pub fn planar(x: f64, y: f64, yaw: f64) -> Self {
        Self {
            position: Point::planar(x, y),
            orientation: Quaternion::from_yaw(yaw),
        }
    }
}

impl Twist {
    /// The velocity of a body that moves in the plane without sliding sideways: `speed` m/s forward, `turn` rad/s.
    pub fn planar(speed: f64, turn: f64) -> Self {
        Self {
            linear: Vector3 {
                x: speed,
                y: 0.0,
                z: 0.0,
            },
            angular: Vector3 {
                x: 0.0,
                y: 0.0,
                z: turn,
            },
        }
    }
}

/// Largest deviation of a quaternion's length from 1.
const QUATERNION_TOLERANCE: f64 = 0.01;

fn check_vector(vector: &Vector3) -> Result<(), DatumError> {
    check_coordinates(vector.x, vector.y, vector.z, LARGEST_POSITION)
}

fn check_point(point: &Point) -> Result<(), DatumError> {
    check_coordinates(point.x, point.y, point.z, LARGEST_POSITION)
}

fn check_twist(twist: &Twist) -> Result<(), DatumError> {
    for (field, vector) in [("linear", &twist.linear), ("angular", &twist.angular)] {
        check_coordinates(vector.x, vector.y, vector.z, LARGEST_SPEED)
            .map_err(|error| error.within(field))?;
    }
    Ok(())
}

fn check_coordinates(x: f64, y: f64, z: f64, largest: f64) -> Result<(), DatumError> {
    bounded("x", x, largest)?;
    bounded("y", y, largest)?;
    bounded("z", z, largest)
}

/// Accepts a unit quaternion, and the quaternion of zeros that a sender leaves out: no rotation.
fn check_quaternion(rotation: &Quaternion) -> Result<(), DatumError> {
    let Quaternion { x, y, z, w } = *rotation;
    let length = (x * x + y * y + z * z + w * w).sqrt();
    if (length - 1.0).abs() <= QUATERNION_TOLERANCE || length == 0.0 {
        Ok(())
    } else {
        Err(implausible("w", "not a unit quaternion"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::PI;

    #[test]
    fn a_turn_about_the_vertical_survives_the_quaternion() {
        for yaw in [0.0, 1.0, -2.5, PI, 3.0] {
            assert!((Quaternion::from_yaw(yaw).yaw() - yaw).abs() < 1e-12);
        }
    }

    #[test]
    fn its_yaw_does_not_mind_tilt_or_length() {
        let tilted = Quaternion {
            x: 0.1,
            y: 0.0,
            z: 0.0,
            w: 0.995,
        };
        assert!(tilted.yaw().abs() < 1e-12);
        let long = Quaternion {
            x: 0.0,
            y: 0.0,
            z: 2.0,
            w: 2.0,
        };
        assert!((long.yaw() - PI / 2.0).abs() < 1e-12);
        let none = Quaternion {
            x: 0.0,
            y: 0.0,
            z: 0.0,
            w: 0.0,
        };
        assert_eq!(none.yaw(), 0.0);
    }
}
