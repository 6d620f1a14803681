//! The component that tells the robots of one world about each other.

use std::collections::BTreeMap;

use asmotion_component::{
    Component, Cycle, Fault, Freeze, In, Interface, NOTICE_REPORT, Out, Ports, freeze_by_fields,
};
use asmotion_messages::{Disc, RoverDisc, RoverDiscs};

/// `nav::sim::Traffic`: collects the places of the robots of a world. Each robot has a [`World`](crate::World) of its own with the
/// same walls, which stops it at the others; their lasers see them.
#[derive(Freeze)]
#[freeze(component = "nav::sim::Traffic", version = 1)]
pub struct Traffic {
    #[freeze(skip)]
    ports: TrafficPorts,

    rovers: BTreeMap<String, Disc>,
    /// Two robots with one name have been reported.
    has_reported: bool,
}

#[derive(Ports)]
struct TrafficPorts {
    /// Places of the robots, from their worlds. Needs a queue for as many samples as there are robots.
    discs: In<RoverDisc>,
    /// Places of all robots, every cycle in which one has moved.
    rovers: Out<RoverDiscs>,
}

/// Distance in m between two places in one cycle that a single robot cannot have driven.
const LEAP: f64 = 1.0;

impl Traffic {
    /// Declares ports.
    pub fn new(interface: &mut Interface) -> Self {
        Self {
            ports: interface.ports(),
            rovers: BTreeMap::new(),
            has_reported: false,
        }
    }
}

impl Component for Traffic {
    freeze_by_fields!();

    fn start(&mut self) -> Result<(), Fault> {
        self.rovers.clear();
        self.has_reported = false;
        Ok(())
    }

    fn update(&mut self, cycle: &mut Cycle<'_>) -> Result<(), Fault> {
        let mut twice = None;
        let mut has_changed = false;
        for RoverDisc { rover, disc } in cycle.all(self.ports.discs) {
            let before = self.rovers.insert(rover.clone(), *disc);
            has_changed |= before.as_ref() != Some(disc);
            if before.is_some_and(|it| (it.x - disc.x).hypot(it.y - disc.y) > LEAP) {
                twice = Some(rover.clone());
            }
        }
        if let Some(rover) = twice.filter(|_| !self.has_reported) {
            self.has_reported = true;
            let text = format!(
                "several robots are called `{rover}`, and do not see each other; the property `rover` of a world names its robot"
            );
            cycle.report(NOTICE_REPORT, text.into());
        }
        if has_changed {
            let rovers = self.rovers.iter().map(|(rover, disc)| RoverDisc {
                rover: rover.clone(),
                disc: *disc,
            });
            let rovers = rovers.collect();
            cycle.write(self.ports.rovers, RoverDiscs { rovers });
        }
        Ok(())
    }
}
