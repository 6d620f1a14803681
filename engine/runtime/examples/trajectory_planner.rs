//! The `TrajectoryPlanner` that task-component architectures use as their example: a periodic task that reads the pose of the
//! robot and a goal from topics, and publishes a trajectory. What is written here is the whole component.
//!
//! `cargo run -p asmotion-runtime --example trajectory_planner`

#![allow(clippy::print_stdout, reason = "an example prints its result")]

use asmotion_component::{Activity, Component, Cycle, Fault, In, Interface, Out, Policy, Span};
use asmotion_runtime::{BuildError, Log, Run, System};

asmotion_datum::message! {
    /// A position in the plane.
    #[derive(Copy)]
    pub struct Position = "example/Position" {
        /// Distance to the east, m.
        pub x: f64,
        /// Distance to the north, m.
        pub y: f64,
    }

    /// Positions to drive through, in order.
    pub struct Trajectory = "example/Trajectory" {
        /// The positions; the first is that of the robot.
        pub points: Vec<Position>,
    }
}

/// Plans a straight trajectory of ten legs to each new goal.
pub struct TrajectoryPlanner {
    pose: In<Position>,
    goal: In<Position>,
    trajectory: Out<Trajectory>,
}

impl TrajectoryPlanner {
    /// Declares the ports; a constructor for [`System::add`].
    pub fn initialize(interface: &mut Interface) -> Box<dyn Component> {
        Box::new(Self {
            pose: interface.input("pose", "position of the robot"),
            goal: interface.input("goal", "where to drive"),
            trajectory: interface.output("trajectory", "the way to the goal"),
        })
    }
}

impl Component for TrajectoryPlanner {
    fn update(&mut self, cycle: &mut Cycle<'_>) -> Result<(), Fault> {
        let (pose, goal) = (cycle.read(self.pose).any(), cycle.read(self.goal).new());
        if let (Some(from), Some(to)) = (pose, goal) {
            let at = |leg: u32| Position {
                x: from.x + (to.x - from.x) * f64::from(leg) / 10.0,
                y: from.y + (to.y - from.y) * f64::from(leg) / 10.0,
            };
            let points = (0..=10).map(at).collect();
            cycle.write(self.trajectory, Trajectory { points });
        }
        Ok(())
    }
}

/// Creates a system with the planner, which cycles every 100 ms.
///
/// # Errors
/// An error if two components have the same name or a topic has two types, which does not occur here.
pub fn system() -> Result<System, BuildError> {
    let mut system = System::new();
    let activity = Activity::periodic(100.ms());
    system.add("Planner", activity, TrajectoryPlanner::initialize)?;
    system.subscribe("pose", "Planner.pose", Policy::data())?;
    system.subscribe("goal", "Planner.goal", Policy::data())?;
    system.publish("Planner.trajectory", "trajectory")?;
    Ok(system)
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let log = Log::new();
    let mut system = system()?;
    system.observe(log.clone());
    let mut run = system.simulate();
    run.inject(run.now(), "Planner.pose", Position { x: 0.0, y: 0.0 })?;
    run.inject(run.now(), "Planner.goal", Position { x: 5.0, y: 2.0 })?;
    run.run_for(200.ms());
    for (at, trajectory) in log.samples::<Trajectory>("Planner.trajectory") {
        println!("{at}: {} points", trajectory.points.len());
    }
    Ok(())
}
