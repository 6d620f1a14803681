//! The service: computes positions of the joints for a pose of the hand.

use asmotion_component::{
    Component, Cycle, Fault, Freeze, Interface, Ports, Provided, ServiceFault, freeze_by_fields,
};
use asmotion_messages::{Goal, JointPositions, Solve};
use nalgebra::{Isometry3, Quaternion, Translation3, UnitQuaternion};

use crate::arm::{Arm, ArmJoints};
use crate::unreachable::Unreachable;

/// `youbot::Kinematics`: provides inverse kinematics; replies with a fault if the pose cannot be reached.
///
/// Stateless: a reply depends only on its request.
#[derive(Freeze)]
#[freeze(component = "youbot::Kinematics", version = 1)]
pub struct Kinematics {
    #[freeze(skip)]
    ports: KinematicsPorts,
    #[freeze(skip)]
    arm: Arm,
}

#[derive(Ports)]
struct KinematicsPorts {
    /// `solve`: positions of the joints, rad, for a pose of the hand in the frame of the foot. Faults `BAD_POSE`,
    /// `OUT_OF_PLANE`, `TOO_FAR`, `TOO_NEAR`, `JOINT_LIMIT`.
    kinematics: Provided<Solve>,
}

impl Kinematics {
    /// Declares the service.
    pub fn new(interface: &mut Interface) -> Self {
        let ports: KinematicsPorts = interface.ports();
        interface.while_stopped(ports.kinematics);
        Self {
            ports,
            arm: Arm::default(),
        }
    }
}

impl Component for Kinematics {
    freeze_by_fields!();

    fn update(&mut self, cycle: &mut Cycle<'_>) -> Result<(), Fault> {
        self.serve(cycle)
    }

    fn serve(&mut self, cycle: &mut Cycle<'_>) -> Result<(), Fault> {
        for request in cycle.requests(self.ports.kinematics) {
            let solved = solve(&self.arm, &request.argument);
            let refused = |why: Unreachable| ServiceFault::new(why.code(), why.to_string());
            cycle.reply(self.ports.kinematics, request.id, solved.map_err(refused));
        }
        Ok(())
    }
}

fn solve(arm: &Arm, goal: &Goal) -> Result<JointPositions, Unreachable> {
    let near = ArmJoints::try_from(goal.near.as_slice()).unwrap_or_default();
    let position = arm.inverse(&isometry(goal)?, &near)?;
    Ok(JointPositions {
        position: position.to_vec(),
    })
}

fn isometry(goal: &Goal) -> Result<Isometry3<f64>, Unreachable> {
    let (place, turn) = (&goal.pose.position, &goal.pose.orientation);
    let turn = Quaternion::new(turn.w, turn.x, turn.y, turn.z);
    let turn = UnitQuaternion::try_new(turn, 1e-6).ok_or(Unreachable::BadPose)?;
    Ok(Isometry3::from_parts(
        Translation3::new(place.x, place.y, place.z),
        turn,
    ))
}
