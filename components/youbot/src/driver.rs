//! The dummy driver of the case study: a data-flow component that reads commands and writes status.

use asmotion_component::{
    Component, Cycle, Fault, Flow, Freeze, In, Interface, Out, Ports, Properties, PropertySet,
    Provided, Setup, freeze_by_fields,
};
use asmotion_messages::Text;
use asmotion_messages::{Bool, DriverSetPeriod, DriverState, Float64, JointCommand, JointStatus};

use crate::joints::{Joints, Manner};
use crate::period::{follow, follow_port};

/// `youbot::DummyDriver`: reads commands, writes status, and provides two operations.
#[derive(Freeze)]
#[freeze(component = "youbot::DummyDriver", version = 2)]
pub struct DummyDriver {
    #[freeze(skip)]
    ports: DriverPorts,
    properties: PropertySet<DriverProperties>,
    joints: Joints,
}

#[derive(Ports)]
struct DriverPorts {
    /// Target positions of the joints, rad. A command for another number of joints is refused: it is counted and
    /// reported, and the joints keep their targets.
    #[port(command)]
    commands: In<JointCommand>,
    /// Period of the driver itself, s, 0.001 to 10; takes effect from its next cycle on. Any other period is refused.
    #[port(command)]
    period: In<Float64>,
    /// Position, velocity, current, temperature and error bits of each joint, every cycle.
    #[port(name = "jointStatus")]
    status: Out<JointStatus>,
    /// Operations of the driver: `setPeriod` sets the period like the port `period` and returns whether it was
    /// accepted; `state` is `resting` or `moving`.
    #[port(name = "driver")]
    set_period: Provided<DriverSetPeriod>,
    /// The driver's state.
    #[port(name = "driver")]
    state: Provided<DriverState>,
}

#[derive(Properties)]
struct DriverProperties {
    /// Number of joints. Read when configured.
    #[property(range = 1..=16, default = 5)]
    joints: u32,
    /// Seed of all random values. Read when configured.
    #[property(default = 1)]
    seed: u64,
    #[property(flatten)]
    manner: Manner,
}

impl DummyDriver {
    /// Declares ports, operations and properties.
    pub fn new(interface: &mut Interface) -> Self {
        Self {
            ports: interface.ports(),
            properties: interface.properties(),
            joints: Joints::new(0, 0),
        }
    }
}

impl Component for DummyDriver {
    freeze_by_fields!();

    fn configure(&mut self, setup: &mut Setup<'_>) -> Result<(), Fault> {
        let DriverProperties { joints, seed, .. } = self.properties.refresh(setup);
        self.joints = Joints::new(*joints as usize, *seed);
        Ok(())
    }

    fn update(&mut self, cycle: &mut Cycle<'_>) -> Result<(), Fault> {
        self.properties.refresh(cycle);
        if let Flow::NewData(command) = cycle.read(self.ports.commands)
            && let Err(wrong) = self.joints.turn_to(&command.position)
        {
            cycle.refuse(self.ports.commands, wrong.to_string());
        }
        follow_port(self.ports.period, cycle);
        for request in cycle.requests(self.ports.set_period) {
            let data = follow(request.argument.period, cycle);
            cycle.reply(self.ports.set_period, request.id, Ok(Bool { data }));
        }
        for request in cycle.requests(self.ports.state) {
            let data = ["moving", "resting"][usize::from(self.joints.are_resting())].to_owned();
            cycle.reply(self.ports.state, request.id, Ok(Text { data }));
        }
        let status = self.joints.measure(cycle.now(), &self.properties.manner);
        cycle.write(self.ports.status, status.clone());
        Ok(())
    }

    fn stop(&mut self, _: &mut Cycle<'_>) {
        self.joints.hold();
    }
}
