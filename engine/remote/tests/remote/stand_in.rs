//! A component that stands for one of another robot, in a system that stops.

use std::time::Duration;

use asmotion_component::{Activity, Component, Cycle, Fault, Interface, Out, Policy, Span};
use asmotion_remote::{Remote, RobotComponent, StandIn};
use asmotion_runtime::{Run, System};

use crate::driver::{Joints, joints};
use crate::robot::Robot;

const PATIENCE: Duration = Duration::from_secs(5);
const MOVES: [f64; 2] = [1.0, 1.0];
const STANDS: [f64; 2] = [0.0, 0.0];

/// Commands a movement in each cycle.
struct Commander(Out<Joints>);

impl Commander {
    fn make(interface: &mut Interface) -> Box<dyn Component> {
        let commands = interface.output("commands", "where to go");
        Box::new(Self(interface.safe(commands, joints(STANDS))))
    }
}

impl Component for Commander {
    fn update(&mut self, cycle: &mut Cycle<'_>) -> Result<(), Fault> {
        cycle.write(self.0, joints(MOVES));
        Ok(())
    }
}

fn stand_in(remote: &Remote) -> impl FnOnce(&mut Interface) -> Box<dyn Component> {
    let declared = remote.announced_component("", "Driver", PATIENCE, |_| true);
    let robot_component = RobotComponent {
        robot: String::new(),
        component: "Driver".to_owned(),
        declaration: RobotComponent::interface(declared.expect("a declaration")),
        used: ["commands".to_owned()].into(),
    };
    let remote = remote.clone();
    move |interface| Box::new(StandIn::new(remote, robot_component, interface))
}

/// The safe command, and no older one after it.
#[test]
fn the_last_command_that_another_robot_receives_is_the_safe_one() {
    for order in [["Commander", "Arm"], ["Arm", "Commander"]] {
        let robot = Robot::start();
        let remote = robot.remote();
        let driver = remote.component("Driver").expect("a component");
        let mut status = driver.watch("status").expect("an output");
        let mut system = System::new();
        for name in order {
            let added = if name == "Arm" {
                system.add(name, Activity::event(), stand_in(&remote))
            } else {
                system.add(name, Activity::periodic(20.ms()), Commander::make)
            };
            added.expect("a component");
        }
        let connected = system.connect("Commander.commands", "Arm.commands", Policy::buffer(16));
        connected.expect("a connection");
        let mut run = system.live();
        let mut next = |patience| {
            let sample = status.next_within(patience)?;
            let sample = sample.content.expect("a sample");
            Some(sample.to::<Joints>().expect("joints").position)
        };
        assert_eq!(next(PATIENCE), Some(MOVES), "{order:?}");
        run.stop();
        drop(run);
        let last = std::iter::from_fn(|| next(Duration::from_millis(500))).last();
        assert_eq!(last, Some(STANDS), "{order:?}");
    }
}
