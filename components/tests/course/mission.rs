//! A coordinator of twenty lines instead of the specification: requests a plan for a goal, and another one when the
//! path is blocked.

use asmotion_component::{Component, Cycle, Fault, Flow, In, Interface, Out, Required};
use asmotion_messages::{Event, OccupancyGrid, Odometry, Path, Plan, PlanRequest, PoseStamped};

/// Requests a path to the goal, passes it on, and requests another one on `BLOCKED`.
pub struct Mission {
    planner: Required<Plan>,
    event: In<Event>,
    odom: In<Odometry>,
    path: Out<Path>,
    map: OccupancyGrid,
    goal: PoseStamped,
    asked: bool,
}

impl Mission {
    pub fn new(interface: &mut Interface, map: OccupancyGrid, goal: PoseStamped) -> Self {
        Self {
            planner: interface.require("planner", "finds paths"),
            event: interface.input("event", "what happens on the way"),
            odom: interface.input("odom", "where the robot is"),
            path: interface.output("path", "the path to follow"),
            map,
            goal,
            asked: false,
        }
    }
}

impl Component for Mission {
    fn update(&mut self, cycle: &mut Cycle<'_>) -> Result<(), Fault> {
        let blocked = cycle
            .all(self.event)
            .iter()
            .any(|event| event.code == Event::BLOCKED);
        if let Flow::NewData(odometry) | Flow::OldData(odometry) = cycle.read(self.odom)
            && (blocked || !self.asked)
        {
            let start = PoseStamped {
                header: odometry.header.clone(),
                pose: odometry.pose.pose,
            };
            let request = PlanRequest {
                map: self.map.clone(),
                start,
                goal: self.goal.clone(),
            };
            self.asked = true;
            cycle.call(self.planner, request);
        }
        for reply in cycle.replies(self.planner) {
            let path = reply.result?;
            cycle.write(self.path, path);
        }
        Ok(())
    }
}
