//! Somebody who wants the hand here and there, one goal after the other.

use component::{CallError, Component, Cycle, Fault, Interface, Property, Provided, Required};
use messages::{MoveTo, Notify, Point, Pose, Quaternion};
use nalgebra::{UnitQuaternion, Vector3};

/// `youbot::Operator`: sends the next goal when the arm is idle, or cannot reach the one before.
pub struct Operator {
    goals: Property<Vec<[f64; 5]>>,
    goto: Required<MoveTo>,
    notifying: Provided<Notify>,
    next: usize,
    waits: bool,
}

impl Operator {
    /// Declares the reference, the service and the property.
    pub fn new(interface: &mut Interface) -> Self {
        Self {
            goals: interface.property(
                "goals",
                Vec::new(),
                "where the hand shall go: x, y, z in m, lean and roll in rad",
            ),
            goto: interface.require("move", "who brings the hand there"),
            notifying: interface.serve("notifying", "hears what happens to the arm"),
            next: 0,
            waits: false,
        }
    }
}

impl Component for Operator {
    fn update(&mut self, cycle: &mut Cycle<'_>) -> Result<(), Fault> {
        let mut notices = cycle.requests(self.notifying).into_iter();
        let arrived = notices.any(|notice| notice.argument.event == "idle");
        for reply in cycle.replies(self.goto) {
            if let Err(error) = reply.result {
                self.waits = false;
                // a goal that cannot be reached is given up; one that came too early is not
                self.next -= usize::from(is_early(&error));
            }
        }
        if arrived {
            self.waits = false;
        }
        if self.waits {
            return Ok(());
        }
        if let Some(goal) = cycle.property(self.goals).get(self.next) {
            cycle.call(self.goto, pose(goal));
            self.next += 1;
            self.waits = true;
        }
        Ok(())
    }
}

/// The arm is still busy with something else.
fn is_early(error: &CallError) -> bool {
    matches!(error, CallError::Fault(fault) if fault.code == "NOT_NOW")
}

/// The hand there, leaning in the plane of the arm: another plane it has not.
fn pose(&[x, y, z, lean, roll]: &[f64; 5]) -> Pose {
    let about = |axis, angle| UnitQuaternion::from_axis_angle(&axis, angle);
    let turn = about(Vector3::z_axis(), y.atan2(x))
        * about(Vector3::y_axis(), lean)
        * about(Vector3::z_axis(), roll);
    Pose {
        position: Point { x, y, z },
        orientation: Quaternion {
            x: turn.i,
            y: turn.j,
            z: turn.k,
            w: turn.w,
        },
    }
}
