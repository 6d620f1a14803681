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
