//! The component that sends the arm to a sequence of goals.

use std::time::Duration;

use asmotion_component::{
    CallError, Component, Cycle, Fault, Freeze, Interface, Ports, Properties, PropertySet,
    Provided, Required, Time, freeze_by_fields,
};
use asmotion_messages::{MoveTo, Notify, Point, Pose, Quaternion};
use nalgebra::{UnitQuaternion, Vector3};
use serde::{Deserialize, Serialize};

/// Time without notices after which an arrival may have been missed.
const SILENCE: Duration = Duration::from_secs(1);

/// `youbot::Operator`: sends the next goal when the arm is idle or cannot reach the previous one.
#[derive(Freeze)]
#[freeze(component = "youbot::Operator", version = 1)]
pub struct YoubotOperator {
    #[freeze(skip)]
    ports: HandOperatorPorts,
    properties: PropertySet<HandOperatorProperties>,
    next: usize,
    state: OperatorState,
    received_at: Option<Time>,
}

#[derive(Ports)]
struct HandOperatorPorts {
    /// Moves the hand to a pose in the frame of the foot.
    #[port(name = "move")]
    locomotion: Required<MoveTo>,
    /// Receives the events of the arm.
    notifying: Provided<Notify>,
}

#[derive(Properties)]
struct HandOperatorProperties {
    /// Poses of the hand to go to, one after the other: x, y, z in m, lean and roll in rad, in the frame of the foot;
    /// the hand leans in the plane of the arm.
    goals: Vec<[f64; 5]>,
}

/// Progress of the last goal.
#[derive(Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
enum OperatorState {
    /// Reached or refused: the next goal can be sent.
    Done,
    /// Accepted: the arm is moving.
    Waits,
    /// Not accepted, or not received: sent again after the next notice.
    Again,
}

impl YoubotOperator {
    /// Declares the reference, the service and the property.
    pub fn new(interface: &mut Interface) -> Self {
        Self {
            ports: interface.ports(),
            properties: interface.properties(),
            next: 0,
            state: OperatorState::Done,
            received_at: None,
        }
    }

    /// Handles the notices about the arm.
    fn listen(&mut self, cycle: &mut Cycle<'_>) {
        let notices = cycle.requests(self.ports.notifying);
        if notices.is_empty() {
            return;
        }
        let now = cycle.now();
        let before = self.received_at.replace(now);
        let was_silent = before.is_some_and(|before| now.since(before) > SILENCE);
        let arrived = notices.iter().any(|it| it.argument.event == "idle");
        self.state = match self.state {
            OperatorState::Waits if arrived => OperatorState::Done,
            OperatorState::Again => self.repeat_last_goal(),
            OperatorState::Waits if was_silent => self.repeat_last_goal(),
            OperatorState::Waits => OperatorState::Waits,
            OperatorState::Done => OperatorState::Done,
        };
    }

    /// Makes the last goal the next one again.
    fn repeat_last_goal(&mut self) -> OperatorState {
        self.next = self.next.saturating_sub(1);
        OperatorState::Done
    }
}

impl Component for YoubotOperator {
    freeze_by_fields!();

    fn update(&mut self, cycle: &mut Cycle<'_>) -> Result<(), Fault> {
        self.listen(cycle);
        for reply in cycle.replies(self.ports.locomotion) {
            if let Err(error) = reply.result {
                self.state = if is_refused(&error) {
                    OperatorState::Done
                } else {
                    OperatorState::Again
                };
            }
        }
        if let OperatorState::Done = self.state
            && let Some(goal) = self.properties.refresh(cycle).goals.get(self.next)
        {
            cycle.call(self.ports.locomotion, pose(goal));
            self.next += 1;
            self.state = OperatorState::Waits;
        }
        Ok(())
    }
}

/// Returns whether the goal cannot be reached; other errors mean that it was too early or that there is no provider.
fn is_refused(error: &CallError) -> bool {
    matches!(error, CallError::Fault(fault) if fault.code != "NOT_NOW")
}

/// The pose of the hand for a goal, in the frame of the base. With five joints, the hand leans only in the plane of the
/// arm.
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
