//! Inverse kinematics: the posture for a pose of the hand, in closed form.
//!
//! The arm moves in a plane that joint 1 turns, with three parallel joints, so the hand can point only along that
//! plane: five joints reach five of the six dimensions of a pose.

use std::f64::consts::{PI, TAU};

use nalgebra::{Isometry3, UnitQuaternion, Vector3};

use crate::arm::{Arm, ArmJoints};
use crate::unreachable::Unreachable;

/// Largest angle in rad between a goal and the arm's plane that is tolerated.
const OUT_OF_PLANE: f64 = 1e-3;

/// Tolerance of comparisons, in m and for sines.
const NOTHING: f64 = 1e-9;

/// A goal in the plane of the arm: the wrist relative to the shoulder, and the direction of the hand.
struct Planar {
    /// Angle of joint 1, rad.
    turn: f64,
    forward: f64,
    up: f64,
    /// Direction of the hand, rad forward from upright.
    pitch: f64,
    /// Angle of joint 5, rad.
    roll: f64,
}

impl Arm {
    /// The posture in which the hand reaches a goal; of several, the one nearest to `reason`.
    ///
    /// # Errors
    /// The reason that the goal cannot be reached, for the posture that comes closest with the arm turned to the goal.
    pub fn inverse(
        &self,
        goal: &Isometry3<f64>,
        near: &ArmJoints,
    ) -> Result<ArmJoints, Unreachable> {
        let coordinates = goal
            .translation
            .vector
            .iter()
            .chain(goal.rotation.coords.iter());
        if !coordinates.copied().all(f64::is_finite) {
            return Err(Unreachable::BadPose);
        }
        let mut best: Option<ArmJoints> = None;
        let mut reason: Option<Unreachable> = None;
        for turn in turns(goal, near) {
            match self.turned(goal, turn, near) {
                Ok(posture)
                    if best.is_none_or(|best| {
                        largest_rotation(&posture, near) < largest_rotation(&best, near)
                    }) =>
                {
                    best = Some(posture);
                }
                Ok(_) => {}
                Err(why) => drop(reason.get_or_insert(why)),
            }
        }
        best.ok_or_else(|| reason.unwrap_or(Unreachable::BadPose))
    }

    /// The posture with joint 1 at this angle; of several, the one nearest to `reason`.
    fn turned(
        &self,
        goal: &Isometry3<f64>,
        turn: f64,
        near: &ArmJoints,
    ) -> Result<ArmJoints, Unreachable> {
        let [one, other] = self.postures(&self.planar(goal, turn)?)?;
        match (self.worst_violation(&one), self.worst_violation(&other)) {
            (None, None) if largest_rotation(&other, near) < largest_rotation(&one, near) => {
                Ok(other)
            }
            (None, _) => Ok(one),
            (Some(_), None) => Ok(other),
            (Some((excess, why)), Some((more, _))) if excess <= more => Err(why),
            (Some(_), Some((_, why))) => Err(why),
        }
    }

    /// The goal in the plane to which joint 1 turns the arm.
    fn planar(&self, goal: &Isometry3<f64>, turn: f64) -> Result<Planar, Unreachable> {
        let back = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), -turn);
        let place = back * goal.translation.vector;
        let rotation = back * goal.rotation;
        let pointing = rotation * Vector3::z();
        let angle = pointing.y.abs().min(1.0).asin();
        if angle > OUT_OF_PLANE {
            return Err(Unreachable::OutOfPlane { angle });
        }
        let pitch = pointing.x.atan2(pointing.z);
        let rolled = UnitQuaternion::from_axis_angle(&Vector3::y_axis(), -pitch) * rotation;
        let side = rolled * Vector3::x();
        Ok(Planar {
            turn,
            forward: place.x - self.offset - self.hand * pitch.sin(),
            up: place.z - self.height - self.hand * pitch.cos(),
            pitch,
            roll: side.y.atan2(side.x),
        })
    }

    /// Both postures, with the elbow on either side.
    fn postures(&self, planar: &Planar) -> Result<[ArmJoints; 2], Unreachable> {
        let Planar {
            forward, up, pitch, ..
        } = *planar;
        let (upper, fore) = (self.upper, self.fore);
        let distance = forward.hypot(up);
        let cosine = (distance.powi(2) - upper.powi(2) - fore.powi(2)) / (2.0 * upper * fore);
        if cosine > 1.0 + NOTHING {
            let reach = upper + fore;
            return Err(Unreachable::TooFar { distance, reach });
        }
        if cosine < -1.0 - NOTHING {
            let least = (upper - fore).abs();
            return Err(Unreachable::TooNear { distance, least });
        }
        let bend = cosine.clamp(-1.0, 1.0).acos();
        Ok([bend, -bend].map(|elbow| {
            let (sin, cos) = elbow.sin_cos();
            let shoulder = forward.atan2(up) - (fore * sin).atan2(upper + fore * cos);
            let wrist = pitch - shoulder - elbow;
            [
                planar.turn,
                wrapped(shoulder),
                elbow,
                wrapped(wrist),
                planar.roll,
            ]
        }))
    }

    /// The joint that would exceed its range by most, and by how much.
    fn worst_violation(&self, posture: &ArmJoints) -> Option<(f64, Unreachable)> {
        let limits = posture.iter().zip(&self.ranges).enumerate();
        let beyond = limits.map(|(index, (&position, &(least, greatest)))| {
            let excess = (least - position).max(position - greatest);
            let joint = index + 1;
            (
                excess,
                Unreachable::JointLimit {
                    joint,
                    position,
                    least,
                    greatest,
                },
            )
        });
        let worst = beyond.max_by(|(one, _), (other, _)| one.total_cmp(other));
        worst.filter(|(excess, _)| *excess > NOTHING)
    }
}

/// The possible angles of joint 1: towards the goal, or away from it; above the base, in the direction of the hand.
fn turns(goal: &Isometry3<f64>, near: &ArmJoints) -> [f64; 2] {
    let place = goal.translation.vector;
    let pointing = goal.rotation * Vector3::z();
    let to = |direction: Vector3<f64>| {
        (direction.x.hypot(direction.y) > NOTHING).then(|| direction.y.atan2(direction.x))
    };
    // straight above the base, pointing straight up or down: any angle is possible, so the current one is kept
    let turn = to(place).or_else(|| to(pointing)).unwrap_or(near[0]);
    [turn, wrapped(turn + PI)]
}

/// The largest rotation of a joint from one posture to the other.
fn largest_rotation(one: &ArmJoints, other: &ArmJoints) -> f64 {
    let turns = one
        .iter()
        .zip(other)
        .map(|(one, other)| (one - other).abs());
    turns.fold(0.0, f64::max)
}

/// Normalises an angle to `-π..=π`.
fn wrapped(angle: f64) -> f64 {
    angle - TAU * (angle / TAU).round()
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Translation3;
    use proptest::prelude::*;

    const UPRIGHT: ArmJoints = [0.0; 5];

    /// A pose of the hand: position, lean forward in the plane of `turn`, and roll.
    fn pose(place: [f64; 3], turn: f64, pitch: f64, roll: f64) -> Isometry3<f64> {
        let about = |axis, angle| UnitQuaternion::from_axis_angle(&axis, angle);
        let rotation = about(Vector3::z_axis(), turn)
            * about(Vector3::y_axis(), pitch)
            * about(Vector3::z_axis(), roll);
        Isometry3::from_parts(Translation3::from(place), rotation)
    }

    fn why(goal: &Isometry3<f64>) -> Unreachable {
        Arm::default().inverse(goal, &UPRIGHT).unwrap_err()
    }

    #[test]
    fn it_says_why_a_goal_cannot_be_reached() {
        let nan = pose([f64::NAN, 0.0, 0.3], 0.0, 0.0, 0.0);
        assert_eq!(why(&nan).code(), "BAD_POSE");
        let sideways = pose([0.3, 0.0, 0.3], 0.5, 1.0, 0.0);
        assert_eq!(why(&sideways).code(), "OUT_OF_PLANE");
        let far = why(&pose([1.0, 0.0, 0.3], 0.0, PI / 2.0, 0.0));
        assert_eq!(
            far.to_string(),
            "the wrist would be 0.765 m from the shoulder, and the arm is 0.290 m long"
        );
        let reason = why(&pose([0.033 + 0.2175, 0.0, 0.147], 0.0, PI / 2.0, 0.0));
        assert_eq!(
            reason.to_string(),
            "the wrist would be 0.000 m from the shoulder, and the arm folds to 0.020 m only"
        );
        let behind = why(&pose([0.033, 0.0, -0.3], 0.0, PI, 0.0));
        assert_eq!(behind.code(), "JOINT_LIMIT");
    }

    #[test]
    fn it_takes_the_posture_nearest_to_the_present_one() {
        let arm = Arm::default();
        let elbow_up = [0.3, 0.2, 1.1, 0.4, -0.2];
        let hand = arm.forward(elbow_up);
        let same = arm.inverse(&hand, &elbow_up).unwrap();
        assert!(largest_rotation(&same, &elbow_up) < 1e-9);
        let elbow_down = arm.inverse(&hand, &[0.3, 1.2, -1.1, 1.4, -0.2]).unwrap();
        assert!(elbow_down[2] < 0.0, "{elbow_down:?}");
    }

    proptest! {
        /// Forward and inverse kinematics agree: the posture found reaches the pose of the original one.
        #[test]
        fn it_finds_back_to_every_pose(
            turn in -2.9..2.9_f64,
            shoulder in -1.1..1.5_f64,
            elbow in -2.6..2.5_f64,
            wrist in -1.7..1.7_f64,
            roll in -2.9..2.9_f64,
        ) {
            let arm = Arm::default();
            let posture = [turn, shoulder, elbow, wrist, roll];
            let goal = arm.forward(posture);
            let found = arm.inverse(&goal, &posture);
            prop_assert!(found.is_ok(), "{found:?}");
            let found = found.unwrap();
            let hand = arm.forward(found);
            let distance = (hand.translation.vector - goal.translation.vector).norm();
            prop_assert!(distance < 1e-6, "{distance} m from the goal");
            prop_assert!(hand.rotation.angle_to(&goal.rotation) < 2e-3);
            prop_assert!(arm.worst_violation(&found).is_none());
        }

        #[test]
        fn it_refuses_or_solves_whatever_it_is_asked(
            place in prop::array::uniform3(-0.8..0.8_f64),
            pitch in -PI..PI,
            roll in -PI..PI,
        ) {
            let arm = Arm::default();
            let goal = pose(place, place[1].atan2(place[0]), pitch, roll);
            if let Ok(found) = arm.inverse(&goal, &UPRIGHT) {
                let hand = arm.forward(found);
                prop_assert!((hand.translation.vector - goal.translation.vector).norm() < 1e-6);
            }
        }
    }
}
