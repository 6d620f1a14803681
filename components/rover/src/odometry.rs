//! Dead reckoning: integrates wheel angles to a pose along exact arcs.

use asmotion_geometry::{Pose, roll};
use asmotion_messages::Encoders;
use serde::{Deserialize, Serialize};

use crate::drive::{DifferentialDrive, Velocity};

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

#[cfg(test)]
mod tests {
    use super::*;
    use asmotion_geometry::{Point, heading, turn, yaw};
    use asmotion_messages::Time;
    use std::f64::consts::FRAC_PI_2;

    const DRIVE: DifferentialDrive = DifferentialDrive {
        wheel_radius_m: 0.05,
        track_m: 0.3,
    };

    fn is_near(pose: &Pose, x: f64, y: f64, angle: f64) -> bool {
        let place = Point::from(pose.translation.vector);
        (place - Point::new(x, y)).norm() < 1e-9 && turn(yaw(pose), angle).abs() < 1e-9
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
}
