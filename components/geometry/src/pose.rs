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

/// The pose after rolling `distance` metres along a circle while turning by `turn` radians.
///
/// Exact for constant wheel speeds: the chord of the arc leaves at half the turn (Siegwart, Nourbakhsh, Scaramuzza:
/// *Introduction to Autonomous Mobile Robots*, 5.2.4, without its small-angle step).
pub fn roll(pose: &Pose, distance: f64, turn: f64) -> Pose {
    let half = turn / 2.0;
    let chord = distance * sinc(half);
    let moved = pose * Point::from(Vector::new(half.cos(), half.sin()) * chord);
    heading(moved, wrap(yaw(pose) + turn))
}

/// sin(x)/x, continued through 0.
fn sinc(x: f64) -> f64 {
    if x.abs() < 1e-4 {
        1.0 - x * x / 6.0 // the next term is below one part in 10¹⁷
    } else {
        x.sin() / x
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use std::f64::consts::FRAC_PI_2;

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

    fn near(pose: &Pose, x: f64, y: f64, angle: f64) -> bool {
        let place = Point::from(pose.translation.vector);
        (place - Point::new(x, y)).norm() < 1e-9 && turn(yaw(pose), angle).abs() < 1e-9
    }

    #[test]
    fn it_rolls_along_arcs_exactly() {
        let start = heading(Point::new(1.0, 2.0), 0.0);
        assert!(near(&roll(&start, 2.0, 0.0), 3.0, 2.0, 0.0));
        assert!(near(&roll(&start, 0.0, 1.0), 1.0, 2.0, 1.0));
        // a quarter and a half of a circle of radius 1 m to the left
        assert!(near(
            &roll(&start, FRAC_PI_2, FRAC_PI_2),
            2.0,
            3.0,
            FRAC_PI_2
        ));
        assert!(near(&roll(&start, PI, PI), 1.0, 4.0, PI));
        // and backwards to the right
        assert!(near(
            &roll(&start, -FRAC_PI_2, -FRAC_PI_2),
            0.0,
            3.0,
            -FRAC_PI_2
        ));
    }

    proptest! {
        #[test]
        fn one_arc_is_as_good_as_many(distance in -3.0..3.0, angle in -6.0..6.0, pieces in 1u32..50) {
            let start = heading(Point::new(-1.0, 0.5), 2.0);
            let whole = roll(&start, distance, angle);
            let share = 1.0 / f64::from(pieces);
            let sum = (0..pieces).fold(start, |pose, _| roll(&pose, distance * share, angle * share));
            prop_assert!(near(&sum, whole.translation.x, whole.translation.y, yaw(&whole)));
        }
    }
}
