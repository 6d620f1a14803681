//! Limits of a detour.

use asmotion_component::Properties;

/// Size of the robot, and limits of a detour.
#[derive(Debug, Clone, Copy, PartialEq, Properties)]
pub struct BendLimits {
    /// Radius of the disc that covers the robot.
    #[property(unit = "m", range = 0.0..=10.0, default = 0.2)]
    pub robot_radius_m: f64,
    /// Smallest distance between the robot's disc and an obstacle.
    #[property(unit = "m", range = 0.0..=10.0, default = 0.08)]
    pub margin_m: f64,
    /// Preferred distance between the robot's disc and an obstacle, kept where the detour costs little.
    #[property(unit = "m", range = 0.0..=10.0, default = 0.2)]
    pub comfort_m: f64,
    /// Largest distance of a detour from the planned path, to either side.
    #[property(unit = "m", range = 0.05..=10.0, default = 1.0)]
    pub reach_m: f64,
    /// Length of path ahead of the robot that is checked for obstacles.
    #[property(unit = "m", range = 0.5..=50.0, default = 4.0)]
    pub horizon_m: f64,
}

impl BendLimits {
    /// Smallest distance between the robot's centre and an obstacle, m.
    pub fn clearance(&self) -> f64 {
        self.robot_radius_m + self.margin_m
    }

    /// Preferred distance between the robot's centre and an obstacle, m; never less than the clearance.
    pub fn comfort(&self) -> f64 {
        self.robot_radius_m + self.comfort_m.max(self.margin_m)
    }
}
