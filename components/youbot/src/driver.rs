//! The dummy driver of the case study: a data-flow component, commands in, status out.

use std::time::Duration;

use asmotion_component::{
    Component, Cycle, Fault, Flow, In, Interface, Out, Property, Provided, Setup,
};
use asmotion_messages::{Bool, DriverSetPeriod, DriverState, Float64, JointCommand, JointStatus};
use asmotion_messages::{Text, Time};

use crate::joints::{Joints, Manner};

/// `youbot::DummyDriver`: it knows no service but its own two operations.
pub struct DummyDriver {
    commands: In<JointCommand>,
    period: In<Float64>,
    status: Out<JointStatus>,
    set_period: Provided<DriverSetPeriod>,
    state: Provided<DriverState>,
    count: Property<u32>,
    seed: Property<u64>,
    random: Property<bool>,
    speed: Property<f64>,
    faults: Property<Vec<u16>>,
    joints: Joints,
}

impl DummyDriver {
    /// Declares ports, operations and properties.
    #[rustfmt::skip]
    pub fn new(interface: &mut Interface) -> Self {
        Self {
            commands: interface.input("commands", "where the joints shall turn"),
            period: interface.input("period", "the period of the driver itself, s"),
            status: interface.output("jointStatus", "what the joints do, every cycle"),
            set_period: interface.serve("driver", "the driver's own operations"),
            state: interface.serve("driver", "the driver's own operations"),
            count: interface.setting("joints", 5, "how many joints there are").range(1..=16).declare(),
            seed: interface.property("seed", 1, "the seed of all chance"),
            random: interface.property("random", false, "values by chance, instead of motion"),
            speed: interface.setting("speed", 1.0, "how fast a joint turns").range(0.01..=10.0).unit("rad/s").declare(),
            faults: interface.property("faults", Vec::new(), "error bits to report, joint by joint"),
            joints: Joints::new(0, 0),
        }
    }
}

impl Component for DummyDriver {
    fn configure(&mut self, setup: &mut Setup<'_>) -> Result<(), Fault> {
        self.joints = Joints::new(
            setup.property(self.count) as usize,
            setup.property(self.seed),
        );
        Ok(())
    }

    fn update(&mut self, cycle: &mut Cycle<'_>) -> Result<(), Fault> {
        if let Flow::NewData(command) = cycle.read(self.commands) {
            self.joints.turn_to(&command.position);
        }
        if let Flow::NewData(&Float64 { data }) = cycle.read(self.period) {
            follow(data, cycle);
        }
        for request in cycle.requests(self.set_period) {
            let data = follow(request.argument.period, cycle);
            cycle.reply(self.set_period, request.id, Ok(Bool { data }));
        }
        for request in cycle.requests(self.state) {
            let data = ["moving", "resting"][usize::from(self.joints.are_resting())].to_owned();
            cycle.reply(self.state, request.id, Ok(Text { data }));
        }
        let manner = Manner {
            random: cycle.property(self.random),
            speed: cycle.property(self.speed),
            faults: cycle.property(self.faults),
        };
        (self.joints).measure(Time::from_nanos(cycle.now().nanos()), &manner);
        cycle.write(self.status, self.joints.last.clone());
        Ok(())
    }
}

/// A period becomes the driver's own, from its next cycle on. Whether it is one.
fn follow(period: f64, cycle: &mut Cycle<'_>) -> bool {
    let lawful = (0.001..=10.0).contains(&period);
    if lawful {
        cycle.set_period(Duration::from_secs_f64(period));
    }
    lawful
}
