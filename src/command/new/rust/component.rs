//! A gripper: closes and opens its fingers.

use asmotion_component::{
    Component, Cycle, Fault, Freeze, In, Interface, Out, Ports, Properties, PropertySet, Time,
    freeze_by_fields,
};
use asmotion_messages::{Bool, Float64};

/// Distance of the fingers when they are open, m.
const OPEN: f64 = 0.08;
/// Distance from an end position at which it counts as reached, m.
const TOLERANCE: f64 = 1e-6;

/// `gripper::Gripper`: closes and opens at a limited speed.
#[derive(Freeze)]
#[freeze(component = "gripper::Gripper", version = 1)]
pub struct Gripper {
    #[freeze(skip)]
    ports: GripperPorts,
    properties: PropertySet<GripperProperties>,
    /// Distance of the fingers, m.
    position: f64,
    /// Time of the last cycle.
    last: Option<Time>,
}

#[derive(Ports)]
struct GripperPorts {
    /// `true` to close, `false` to open.
    closing: In<Bool>,
    /// Whether the fingers are closed; written in each cycle.
    closed: Out<Bool>,
    /// Whether the fingers are open; written in each cycle.
    opened: Out<Bool>,
    /// Distance of the fingers, m; written in each cycle.
    position: Out<Float64>,
}

#[derive(Properties)]
struct GripperProperties {
    /// Speed of the fingers.
    #[property(unit = "m/s", range = 0.01..=0.5, default = 0.1)]
    speed: f64,
}

impl Gripper {
    /// Declares ports and properties.
    pub fn new(interface: &mut Interface) -> Self {
        Self {
            ports: interface.ports(),
            properties: interface.properties(),
            position: OPEN,
            last: None,
        }
    }
}

impl Component for Gripper {
    freeze_by_fields!();

    fn update(&mut self, cycle: &mut Cycle<'_>) -> Result<(), Fault> {
        self.properties.refresh(cycle);
        let now = cycle.now();
        let elapsed = self.last.map_or(0.0, |last| now.since(last).as_secs_f64());
        self.last = Some(now);
        if let Some(closing) = cycle.read(self.ports.closing).any() {
            let target = if closing.data { 0.0 } else { OPEN };
            let step = self.properties.speed * elapsed;
            self.position += (target - self.position).clamp(-step, step);
        }
        let position = self.position;
        let closed = position < TOLERANCE;
        let opened = position > OPEN - TOLERANCE;
        cycle.write(self.ports.closed, Bool { data: closed });
        cycle.write(self.ports.opened, Bool { data: opened });
        cycle.write(self.ports.position, Float64 { data: position });
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use std::time::Duration;

    use asmotion_bench::{Bench, BenchError};

    use super::*;

    #[test]
    fn it_keeps_the_contract_of_components() {
        assert_eq!(asmotion::contract::component(Gripper::new), [""; 0]);
    }

    #[test]
    fn it_moves_at_its_speed() -> Result<(), BenchError> {
        let mut bench = Bench::new(Gripper::new);
        bench.period(Duration::from_millis(100)).set("speed", 0.2);
        bench.give("closing", Bool { data: true }).cycle()?;
        let position = bench.cycle()?.output::<Float64>("position");
        assert!(position.is_some_and(|it| (it.data - 0.06).abs() < 1e-9));
        Ok(())
    }
}
