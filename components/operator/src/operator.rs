//! The component.

use asmotion_component::{Component, Cycle, Fault, Interface, Out, Property, Setup};
use asmotion_geometry::{Point, heading, message};
use asmotion_messages::{Bool, Empty, PoseStamped};

use crate::script::{Command, Deed};

/// `nav::Operator`: does what its script says.
pub struct Operator {
    goal: Out<PoseStamped>,
    cancel: Out<Empty>,
    estop: Out<Bool>,
    script: Property<Vec<String>>,
    /// What is still to be done, the next deed last.
    deeds: Vec<Deed>,
    /// ns, of the first cycle.
    began: Option<i64>,
}

impl Operator {
    /// Declares ports and the script.
    pub fn new(interface: &mut Interface) -> Self {
        Self {
            goal: interface.output("goal", "where the robot shall go, map frame"),
            cancel: interface.output("cancel", "the mission is called off"),
            estop: interface.output("estop", "the e-stop is pressed, or let go of"),
            script: interface.property(
                "script",
                Vec::new(),
                "what is done when: `1.0 goal 26.4 4.2`, `8 estop on`, `12 cancel`; s and m",
            ),
            deeds: Vec::new(),
            began: None,
        }
    }
}

impl Component for Operator {
    fn configure(&mut self, setup: &mut Setup<'_>) -> Result<(), Fault> {
        let script = setup.property(self.script);
        self.deeds = script
            .iter()
            .map(|line| line.parse())
            .collect::<Result<_, _>>()?;
        // deeds of one time are done in the order of the script
        self.deeds.reverse();
        self.deeds.sort_by(|a, b| b.at.total_cmp(&a.at));
        self.began = None;
        Ok(())
    }

    fn update(&mut self, cycle: &mut Cycle<'_>) -> Result<(), Fault> {
        let now = cycle.now().nanos();
        let since = (now - *self.began.get_or_insert(now)) as f64 * 1e-9;
        while let Some(deed) = self.deeds.pop_if(|deed| deed.at <= since) {
            match deed.command {
                Command::Goal { x, y, yaw } => {
                    let pose = heading(Point::new(x, y), yaw);
                    cycle.write(self.goal, message::pose_stamped(&pose, now, "map"));
                }
                Command::Cancel => cycle.write(self.cancel, Empty::default()),
                Command::Estop(pressed) => cycle.write(self.estop, Bool { data: pressed }),
            }
        }
        Ok(())
    }
}
