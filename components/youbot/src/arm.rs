//! The KUKA youBot's arm: lengths, ranges and forward kinematics.
//!
//! Lengths and ranges are those of KUKA's data sheet, as `youbot_description` has them: axis 2 is 33 mm in front of and
//! 147 mm above the base of axis 1, upper arm 155 mm, forearm 135 mm, hand 217.5 mm; ranges ±169°, −65°…90°,
//! −151°…146°, ±102.5°, ±167.5°. All joints at zero, the arm stands upright; joint 1 turns counter-clockwise seen from
//! above, joints 2 to 4 lean forward.

use nalgebra::{Isometry3, Translation3, UnitQuaternion, Vector3};

/// Positions of the five joints, rad.
pub type ArmJoints = [f64; 5];

/// The dimensions of an arm of this type.
#[derive(Clone, Debug, PartialEq)]
pub struct Arm {
    /// Horizontal distance from axis 1 to axis 2, m.
    pub offset: f64,
    /// Height of axis 2 above the base, m.
    pub height: f64,
    /// Length of the upper arm, from axis 2 to axis 3, m.
    pub upper: f64,
    /// Length of the forearm, from axis 3 to axis 4, m.
    pub fore: f64,
    /// Length of the hand, from axis 4 to its end, m.
    pub hand: f64,
    /// Smallest and largest position of each joint, rad.
    pub ranges: [(f64, f64); 5],
}

impl Default for Arm {
    /// The dimensions of KUKA's youBot.
    fn default() -> Self {
        let range = |least: f64, greatest: f64| (least.to_radians(), greatest.to_radians());
        Self {
            offset: 0.033,
            height: 0.147,
            upper: 0.155,
            fore: 0.135,
            hand: 0.2175,
            ranges: [
                range(-169.0, 169.0),
                range(-65.0, 90.0),
                range(-151.0, 146.0),
                range(-102.5, 102.5),
                range(-167.5, 167.5),
            ],
        }
    }
}

impl Arm {
    /// Pose of the hand in a posture (rad), in the frame of the base, m; z points out of the hand.
    pub fn forward(&self, [turn, shoulder, elbow, wrist, roll]: ArmJoints) -> Isometry3<f64> {
        let about_z = |angle| UnitQuaternion::from_axis_angle(&Vector3::z_axis(), angle);
        let lean = |angle| UnitQuaternion::from_axis_angle(&Vector3::y_axis(), angle);
        let along = |length| Translation3::new(0.0, 0.0, length);
        about_z(turn)
            * Translation3::new(self.offset, 0.0, self.height)
            * lean(shoulder)
            * along(self.upper)
            * lean(elbow)
            * along(self.fore)
            * lean(wrist)
            * along(self.hand)
            * about_z(roll)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::PI;

    #[test]
    fn it_stands_upright_at_zero() {
        let hand = Arm::default().forward([0.0; 5]);
        let expected = Vector3::new(0.033, 0.0, 0.147 + 0.155 + 0.135 + 0.2175);
        assert!((hand.translation.vector - expected).norm() < 1e-12);
        let bent = Arm::default().forward([PI / 2.0, PI / 2.0, 0.0, 0.0, 0.0]);
        let expected = Vector3::new(0.0, 0.033 + 0.155 + 0.135 + 0.2175, 0.147);
        assert!((bent.translation.vector - expected).norm() < 1e-12);
    }
}
