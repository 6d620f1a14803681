//! Measured motion.

use asmotion_geometry::{Pose, yaw};

/// Measured pose and velocity of the robot, from odometry.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MeasuredMotion {
    /// Pose in the frame of the path.
    pub pose: Pose,
    /// Forward speed, m/s.
    pub speed: f64,
    /// Turn rate, rad/s counter-clockwise.
    pub turn: f64,
}

impl MeasuredMotion {
    /// Returns whether every number is finite.
    pub fn is_finite(&self) -> bool {
        let place = self.pose.translation;
        [place.x, place.y, yaw(&self.pose), self.speed, self.turn]
            .iter()
            .all(|number| number.is_finite())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use asmotion_geometry::{Point, heading};

    #[test]
    fn each_number_must_be_finite() {
        let finite = [1.0, -2.0, 0.5, 0.3, -0.1];
        let motion = |[x, y, yaw, speed, turn]: [f64; 5]| MeasuredMotion {
            pose: heading(Point::new(x, y), yaw),
            speed,
            turn,
        };
        assert!(motion(finite).is_finite());
        for index in 0..finite.len() {
            for wrong in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
                let mut numbers = finite;
                numbers[index] = wrong;
                assert!(!motion(numbers).is_finite(), "{numbers:?}");
            }
        }
    }
}
