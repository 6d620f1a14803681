//! Dead reckoning: integrates wheel angles to a pose along exact arcs.

use asmotion_geometry::{Pose, Vector, heading, wrap, yaw};
use asmotion_messages::Encoders;
use serde::{Deserialize, Serialize};

use crate::drive::{DifferentialDrive, Velocity};

/// The pose after rolling `distance` metres along a circle while turning by `turn` radians.
///
/// Exact for constant wheel speeds: the chord of the arc leaves at half the turn (Siegwart, Nourbakhsh, Scaramuzza:
/// *Introduction to Autonomous Mobile Robots*, 5.2.4, without its small-angle step).
pub fn roll(pose: &Pose, distance: f64, turn: f64) -> Pose {
    let half = turn / 2.0;
    let chord = distance * sinc(half);
    let moved = pose * asmotion_geometry::Point::from(Vector::new(half.cos(), half.sin()) * chord);
    heading(moved, wrap(yaw(pose) + turn))
}

/// Dead reckoning from wheel angles.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct Odometer {
    pose: Pose,
    velocity: Velocity,
    last: Option<Encoders>,
}

impl Odometer {
    /// Starts at the pose `start`; the first reading of the encoders becomes their zero.
    pub fn new(start: Pose) -> Self {
        Self {
            pose: start,
            velocity: Velocity::default(),
            last: None,
        }
    }

    /// Integrates one reading of the encoders. The first only sets the zero.
    pub fn update(&mut self, drive: &DifferentialDrive, encoders: &Encoders) {
        if let Some(last) = &self.last {
            let rolled = drive.body(encoders.left - last.left, encoders.right - last.right);
            self.pose = roll(&self.pose, rolled.speed, rolled.turn);
            let seconds = (encoders.stamp.as_nanos() - last.stamp.as_nanos()) as f64 * 1e-9;
            if seconds > 0.0 {
                self.velocity = Velocity {
                    speed: rolled.speed / seconds,
                    turn: rolled.turn / seconds,
                };
            }
        }
        self.last = Some(*encoders);
    }

    /// Pose of the robot, in the frame of the start pose.
    pub fn pose(&self) -> &Pose {
        &self.pose
    }

    /// Mean velocity between the last two readings.
    pub fn velocity(&self) -> Velocity {
        self.velocity
    }
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
    use asmotion_geometry::{Point, turn};
    use asmotion_messages::Time;
    use proptest::prelude::*;
    use std::f64::consts::{FRAC_PI_2, PI};

    const DRIVE: DifferentialDrive = DifferentialDrive {
        wheel_radius_m: 0.05,
        track_m: 0.3,
    };

    fn is_near(pose: &Pose, x: f64, y: f64, angle: f64) -> bool {
        let place = Point::from(pose.translation.vector);
        (place - Point::new(x, y)).norm() < 1e-9 && turn(yaw(pose), angle).abs() < 1e-9
    }

    #[test]
    fn it_rolls_along_arcs_exactly() {
        let start = heading(Point::new(1.0, 2.0), 0.0);
        assert!(is_near(&roll(&start, 2.0, 0.0), 3.0, 2.0, 0.0));
        assert!(is_near(&roll(&start, 0.0, 1.0), 1.0, 2.0, 1.0));
        // a quarter and a half of a circle of radius 1 m to the left
        assert!(is_near(
            &roll(&start, FRAC_PI_2, FRAC_PI_2),
            2.0,
            3.0,
            FRAC_PI_2
        ));
        assert!(is_near(&roll(&start, PI, PI), 1.0, 4.0, PI));
        // and backwards to the right
        assert!(is_near(
            &roll(&start, -FRAC_PI_2, -FRAC_PI_2),
            0.0,
            3.0,
            -FRAC_PI_2
        ));
    }

    #[test]
    fn it_counts_from_the_first_reading() {
        let mut odometer = Odometer::new(heading(Point::new(1.0, 1.0), FRAC_PI_2));
        let reading = |seconds: f64, angle: f64| Encoders {
            stamp: Time::from_nanos((seconds * 1e9) as i64),
            left: angle,
            right: angle,
        };
        odometer.update(&DRIVE, &reading(5.0, 1000.0));
        assert!(is_near(odometer.pose(), 1.0, 1.0, FRAC_PI_2));
        odometer.update(&DRIVE, &reading(5.5, 1004.0));
        assert!(is_near(odometer.pose(), 1.0, 1.2, FRAC_PI_2));
        assert!((odometer.velocity().speed - 0.4).abs() < 1e-9);
    }

    proptest! {
        #[test]
        fn one_arc_is_as_good_as_many(distance in -3.0..3.0, angle in -6.0..6.0, pieces in 1u32..50) {
            let start = heading(Point::new(-1.0, 0.5), 2.0);
            let whole = roll(&start, distance, angle);
            let share = 1.0 / f64::from(pieces);
            let sum = (0..pieces).fold(start, |pose, _| roll(&pose, distance * share, angle * share));
            prop_assert!(is_near(&sum, whole.translation.x, whole.translation.y, yaw(&whole)));
        }
    }
}
