//! The component.

use asmotion_component::{
    Component, Cycle, Fault, Freeze, Interface, Out, Ports, Properties, PropertySet, Setup, Time,
    freeze_by_fields,
};
use asmotion_geometry::{Point, heading, message};
use asmotion_messages::{Bool, Empty, PoseStamped};

use crate::script::{OperatorCommand, ScheduledCommand, ScriptLine};

/// `nav::Operator`: carries out a script of timed commands.
#[derive(Freeze)]
#[freeze(component = "nav::Operator", version = 1)]
pub struct ScriptedOperator {
    #[freeze(skip)]
    ports: OperatorPorts,
    /// Read when configured.
    properties: PropertySet<OperatorProperties>,
    /// Remaining commands, in reverse order.
    scheduled: Vec<ScheduledCommand>,
    /// Time of the first cycle, from which the script's times count.
    began: Option<Time>,
}

#[derive(Ports)]
struct OperatorPorts {
    /// Pose to send the robot to, map frame.
    goal: Out<PoseStamped>,
    /// Cancels the mission.
    cancel: Out<Empty>,
    /// State of the e-stop button: true while pressed.
    estop: Out<Bool>,
}

#[derive(Properties)]
struct OperatorProperties {
    /// Timed commands: `1.0 goal 26.4 4.2 0` (s, m, m, rad; map frame), `8 estop on`, `9 estop off`, `12 cancel`.
    /// Times count from the first cycle.
    script: Vec<ScriptLine>,
}

impl ScriptedOperator {
    /// Declares ports and the script.
    pub fn new(interface: &mut Interface) -> Self {
        Self {
            ports: interface.ports(),
            properties: interface.properties(),
            scheduled: Vec::new(),
            began: None,
        }
    }
}

impl Component for ScriptedOperator {
    freeze_by_fields!();

    fn configure(&mut self, setup: &mut Setup<'_>) -> Result<(), Fault> {
        let script = self.properties.refresh(setup).script.iter();
        self.scheduled = script.map(|line| line.scheduled).collect();
        // commands with the same time keep the order of the script
        self.scheduled.reverse();
        self.scheduled.sort_by(|a, b| b.at.total_cmp(&a.at));
        self.began = None;
        Ok(())
    }

    fn update(&mut self, cycle: &mut Cycle<'_>) -> Result<(), Fault> {
        let now = cycle.now();
        let began = *self.began.get_or_insert(now);
        let since = (now.nanos() - began.nanos()) as f64 * 1e-9;
        while let Some(next) = self.scheduled.pop_if(|next| next.at <= since) {
            match next.command {
                OperatorCommand::Goal { x, y, yaw } => {
                    let pose = heading(Point::new(x, y), yaw);
                    cycle.write(
                        self.ports.goal,
                        message::pose_stamped(&pose, now.nanos(), "map"),
                    );
                }
                OperatorCommand::Cancel => cycle.write(self.ports.cancel, Empty::default()),
                OperatorCommand::Estop(pressed) => {
                    cycle.write(self.ports.estop, Bool { data: pressed })
                }
            }
        }
        Ok(())
    }
}
