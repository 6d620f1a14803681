//! Poses in the plane (nalgebra's isometries), and angles.

use std::f64::consts::{PI, TAU};

/// A position, m.
pub type Point = nalgebra::Point2<f64>;

/// A displacement or direction, m.
pub type Vector = nalgebra::Vector2<f64>;

/// A position (m) and orientation (rad): maps coordinates of the body to those of its reference frame.
pub type Pose = nalgebra::Isometry2<f64>;

/// The pose at `point` with heading `yaw`, in rad counter-clockwise from x.
pub fn heading(point: Point, yaw: f64) -> Pose {
    Pose::new(point.coords, yaw)
}

/// Heading of a pose, rad in `-π..=π`.
pub fn yaw(pose: &Pose) -> f64 {
    pose.rotation.angle()
}

/// Normalises an angle to `-π..=π`, rad; not finite if the angle is not.
pub fn wrap(angle: f64) -> f64 {
    if angle.abs() <= PI {
        return angle;
    }
    let turned = angle.rem_euclid(TAU);
    if turned > PI { turned - TAU } else { turned }
}

/// The shorter turn from one angle to another, rad in `-π..=π`.
pub fn turn(from: f64, to: f64) -> f64 {
    wrap(to - from)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_turns_the_short_way_round() {
        assert!((turn(3.0, -3.0) - (TAU - 6.0)).abs() < 1e-12);
        assert!((turn(-3.0, 3.0) - (6.0 - TAU)).abs() < 1e-12);
    }

    #[test]
    fn it_keeps_half_a_turn_on_its_side() {
        assert_eq!((wrap(PI), wrap(-PI)), (PI, -PI));
        assert!((wrap(7.0 * PI).abs() - PI).abs() < 1e-9);
    }

    #[test]
    fn a_pose_remembers_where_it_looks() {
        let pose = heading(Point::new(1.0, 2.0), 2.5);
        assert!((yaw(&pose) - 2.5).abs() < 1e-12);
        assert_eq!(pose * Point::origin(), Point::new(1.0, 2.0));
    }
}
