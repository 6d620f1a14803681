//! A course: walls, obstacles and a given path, which the robot's reactive layer drives in simulated time.

pub mod mission;

use std::sync::{Arc, Mutex};

use asmotion_adapter::TrajectoryAdapter;
use asmotion_collision_monitor::CollisionMonitor;
use asmotion_component::{Activity, Component, Interface, Policy, Span, Time, Wire};
use asmotion_datum::{Datum, Message, Sample};
use asmotion_follower::TrajectoryFollower;
use asmotion_geometry::{Grid, GridLayout, ObstacleScene, Point, Polyline, Pose, message};
use asmotion_laser::LaserDriver;
use asmotion_messages::{OccupancyGrid, Path, PoseStamped, Twist, WheelSpeeds};
use asmotion_rover::RoverDriver;
use asmotion_runtime::{Event, Run, Simulation, System};
use asmotion_world::{Obstacle, World};

/// The surroundings and the task of the robot.
#[derive(Clone, Default)]
pub struct Course {
    /// Map file with walls; empty for none.
    pub floor_plan: String,
    /// Additional walls: x1, y1, x2, y2 of each, m.
    pub walls: Vec<f64>,
    /// Obstacles with their times.
    pub obstacles: Vec<Obstacle>,
    /// Pose at the start: x m, y m, yaw rad.
    pub start: [f64; 3],
    /// Corners of the path, m.
    pub path: Vec<(f64, f64)>,
    /// The map; `None` for a robot without one.
    pub map: Option<OccupancyGrid>,
    /// `true` if the adapter does not get the map.
    pub adapter_without_map: bool,
    /// Seed of laser and world.
    pub seed: u64,
    /// Speed limit of the follower, m/s; `None` for its default.
    pub speed: Option<f64>,
    /// Radius of the robot, m; `None` for the default of each component.
    pub radius: Option<f64>,
    /// Distance that the adapter keeps between the robot's disc and obstacles, m; `None` for its default.
    pub margin: Option<f64>,
    /// Smallest distance of planned paths from obstacles, m; `None` for what the adapter requires.
    pub inflation: Option<f64>,
    /// `true` if the follower does not get the scan.
    pub blind_follower: bool,
    /// `true` if the follower commands the rover directly.
    pub unmonitored: bool,
}

/// The record of a drive.
#[derive(Clone, Default)]
pub struct Drive {
    /// Time in s and true pose, every 20 ms.
    pub track: Vec<(f64, Pose)>,
    /// Time in s, code and detail of each event.
    pub events: Vec<(f64, String, String)>,
    /// Time in s and path, as published by the adapter.
    pub paths: Vec<(f64, Path)>,
    /// Time in s and twist commanded by the follower.
    pub twists: Vec<(f64, Twist)>,
    /// Time in s and twist passed on by the monitor.
    pub passed: Vec<(f64, Twist)>,
    /// Time in s and commanded wheel speeds.
    pub wheels: Vec<(f64, WheelSpeeds)>,
    /// The obstacles last published by the adapter.
    pub obstacles: Vec<Point>,
    /// Smallest distance between the robot's centre and any obstacle, m.
    pub nearest: f64,
    /// Faults of components, as text.
    pub faults: Vec<String>,
    scene: ObstacleScene,
}

/// A running course and its record.
pub struct Running {
    pub run: Simulation,
    pub drive: Arc<Mutex<Drive>>,
}

/// Time at which the path is given, s.
pub const GO: f64 = 0.3;

impl Course {
    /// A corridor of two metres width: ten metres straight, then five to the left.
    pub fn corridor() -> Self {
        let corners = [
            [-1.0, 1.0, 9.0, 1.0],
            [-1.0, -1.0, 11.0, -1.0],
            [-1.0, -1.0, -1.0, 1.0],
            [9.0, 1.0, 9.0, 6.0],
            [11.0, -1.0, 11.0, 6.0],
            [9.0, 6.0, 11.0, 6.0],
        ];
        Self {
            walls: corners.concat(),
            start: [0.0, 0.0, 0.3],
            path: vec![(0.0, 0.0), (10.0, 0.0), (10.0, 5.0)],
            seed: 1,
            ..Self::default()
        }
    }

    /// The demo's office with its map; the robot is at the dock.
    pub fn office() -> Self {
        let file = concat!(
            env!("CARGO_MANIFEST_DIR"),
            "/../specs/navigation/maps/office.geojson"
        );
        let plan = asmotion_map::load(
            &asmotion_map::DiskFiles,
            file,
            &asmotion_map::MapSettings::default(),
        )
        .unwrap();
        Self {
            floor_plan: file.to_owned(),
            start: [1.4, 4.7, 0.0],
            map: Some(message::occupancy_grid(&plan.grid, 0, "map")),
            seed: 1,
            ..Self::default()
        }
    }

    /// Adds an obstacle.
    pub fn with(mut self, obstacle: Obstacle) -> Self {
        self.obstacles.push(obstacle);
        self
    }

    /// Sets the seed.
    pub fn seed(self, seed: u64) -> Self {
        Self { seed, ..self }
    }

    /// The path as a message, stamped with the time at which it is given.
    pub fn message(&self) -> Path {
        let line = Polyline::new(self.path.iter().map(|(x, y)| Point::new(*x, *y)));
        message::path(&line.resampled(0.1), nanos(GO), "map")
    }

    /// Starts the system; the path is given at its time.
    pub fn run(&self) -> Running {
        let (system, drive) = self.system();
        let mut run = system.simulate();
        self.tell_map(&mut run);
        if !self.path.is_empty() {
            run.inject(Time::from_nanos(nanos(GO)), "Adapter.path", self.message())
                .unwrap();
        }
        Running { run, drive }
    }

    /// Starts the system with a planner and a mission to a goal.
    pub fn mission(&self, goal: (f64, f64)) -> Running {
        let (mut system, drive) = self.system();
        let map = self.map.clone().unwrap();
        let goal = message::pose_stamped(
            &asmotion_geometry::heading(Point::new(goal.0, goal.1), 0.0),
            0,
            "map",
        );
        add(
            &mut system,
            "Planner",
            100,
            asmotion_planner::TrajectoryPlanner::new,
        );
        if let Some(radius) = self.radius {
            let required = radius + self.margin.unwrap_or(0.08) + 0.005;
            let inflation = self.inflation.unwrap_or(required);
            let inflation = Datum::of(&inflation).unwrap();
            set(&mut system, "Planner", "inflation_m", inflation);
        }
        let make = |interface: &mut Interface| {
            Box::new(mission::Mission::new(interface, map.clone(), goal)) as Box<dyn Component>
        };
        system
            .add("Mission", Activity::periodic(50.ms()), make)
            .unwrap();
        for (from, to) in [
            ("Adapter.obstacles", "Planner.obstacles"),
            ("Adapter.event", "Mission.event"),
            ("Rover.odom", "Mission.odom"),
            ("Mission.path", "Adapter.path"),
        ] {
            system.connect(from, to, Policy::circular(8)).unwrap();
        }
        system
            .wire("Mission.planner", "Planner.planning", Wire::default())
            .unwrap();
        let mut run = system.simulate();
        self.tell_map(&mut run);
        Running { run, drive }
    }

    fn tell_map(&self, run: &mut Simulation) {
        if let (Some(map), false) = (&self.map, self.adapter_without_map) {
            run.inject(Time::ZERO, "Adapter.map", map.clone()).unwrap();
        }
    }

    fn system(&self) -> (System, Arc<Mutex<Drive>>) {
        let mut system = System::new();
        add(&mut system, "World", 20, World::new);
        add(&mut system, "Laser", 50, LaserDriver::new);
        add(&mut system, "Rover", 20, RoverDriver::new);
        add(&mut system, "Adapter", 100, TrajectoryAdapter::new);
        add(&mut system, "Follower", 50, TrajectoryFollower::new);
        if !self.unmonitored {
            add(&mut system, "Monitor", 20, CollisionMonitor::new);
        }
        for (component, property, value) in [
            ("World", "floor_plan", Datum::of(&self.floor_plan).unwrap()),
            ("World", "walls", Datum::of(&self.walls).unwrap()),
            ("World", "obstacles", obstacles(&self.obstacles)),
            ("World", "start", Datum::of(&self.start).unwrap()),
            ("World", "seed", Datum::of(&self.seed).unwrap()),
            ("Laser", "seed", Datum::of(&self.seed).unwrap()),
            ("Laser", "dropout", Datum::of(&0.01).unwrap()),
            ("Rover", "start", Datum::of(&self.start).unwrap()),
        ] {
            set(&mut system, component, property, value);
        }
        if let Some(speed) = self.speed {
            set(
                &mut system,
                "Follower",
                "max_speed",
                Datum::of(&speed).unwrap(),
            );
            set(
                &mut system,
                "Rover",
                "max_speed",
                Datum::of(&(speed * 1.1)).unwrap(),
            );
            set(
                &mut system,
                "Rover",
                "max_wheel_speed",
                Datum::of(&200.0).unwrap(),
            );
        }
        if let Some(radius) = self.radius {
            let with_radius = ["World", "Adapter", "Follower", "Monitor"];
            let known = with_radius.iter().filter(|it| system.id(it).is_some());
            for component in known.copied().collect::<Vec<_>>() {
                set(
                    &mut system,
                    component,
                    "robot_radius_m",
                    Datum::of(&radius).unwrap(),
                );
            }
        }
        if let Some(margin) = self.margin {
            let margin = Datum::of(&margin).unwrap();
            set(&mut system, "Adapter", "margin_m", margin);
        }
        for (from, to, policy) in [
            ("World.scene", "Laser.scene", Policy::data()),
            ("World.truth", "Laser.truth", Policy::data()),
            ("World.encoders", "Rover.encoders", Policy::data()),
            ("Rover.wheels", "World.wheels", Policy::data()),
            ("Rover.odom", "Adapter.odom", Policy::circular(16)),
            ("Rover.odom", "Follower.odom", Policy::data()),
            ("Laser.scan", "Adapter.scan", Policy::data()),
            ("Adapter.adapted", "Follower.path", Policy::circular(2)),
        ] {
            system.connect(from, to, policy).unwrap();
        }
        if !self.blind_follower {
            system
                .connect("Laser.scan", "Follower.scan", Policy::data())
                .unwrap();
        }
        let chain: &[(&str, &str)] = if self.unmonitored {
            &[("Follower.twist", "Rover.twist")]
        } else {
            &[
                ("Follower.twist", "Monitor.command"),
                ("Laser.scan", "Monitor.scan"),
                ("Rover.odom", "Monitor.odom"),
                ("Monitor.twist", "Rover.twist"),
            ]
        };
        for (from, to) in chain {
            system.connect(from, to, Policy::data()).unwrap();
        }
        let drive = Arc::new(Mutex::new(Drive {
            nearest: f64::INFINITY,
            ..Drive::default()
        }));
        let seen = Arc::clone(&drive);
        system.observe(move |at: Time, event: &Event<'_>| {
            seen.lock().unwrap().see(at.seconds(), event)
        });
        (system, drive)
    }

    /// Adds a map of the walls with cells of 5 cm, without the obstacles.
    pub fn with_map(mut self) -> Self {
        let layout = GridLayout::new(
            0.05,
            280,
            180,
            asmotion_geometry::heading(Point::new(-1.5, -2.0), 0.0),
        )
        .unwrap();
        let mut grid = Grid::new(layout, asmotion_geometry::FREE);
        let (walls, _) = self.walls.as_chunks::<4>();
        for [x1, y1, x2, y2] in walls {
            grid.stroke(
                &[Point::new(*x1, *y1), Point::new(*x2, *y2)],
                0.0,
                asmotion_geometry::OCCUPIED,
            );
        }
        self.map = Some(message::occupancy_grid(&grid, 0, "map"));
        self
    }

    /// Runs until one second after the robot has reached the goal, at most `seconds`.
    pub fn drive(&self, seconds: f64) -> Drive {
        let mut running = self.run();
        let end = Time::from_nanos(nanos(seconds));
        let reached = |_, event: &Event<'_>| {
            let Event::Published {
                component: "Follower",
                port: "event",
                sample,
                ..
            } = event
            else {
                return false;
            };
            of::<asmotion_messages::Event>(*sample).code == asmotion_messages::Event::REACHED
        };
        if running.run.run_until_event(end, &mut { reached }) {
            running.run.run_for(1.s());
        }
        let drive = running.drive.lock().unwrap();
        drive.clone()
    }
}

impl Drive {
    fn see(&mut self, at: f64, event: &Event<'_>) {
        if let Event::Published {
            component,
            port,
            sample,
            ..
        } = event
        {
            self.hear(at, component, port, *sample);
        }
        if let Event::Fault { component, fault } = event {
            self.faults.push(format!("{component}: {fault}"));
        }
    }

    fn hear(&mut self, at: f64, component: &str, port: &str, sample: &dyn Sample) {
        match (component, port) {
            ("World", "truth") => {
                let pose = message::pose(&of::<PoseStamped>(sample).pose);
                let clearance = self
                    .scene
                    .clearance_within(pose.translation.vector.into(), 5.0);
                self.nearest = self.nearest.min(clearance);
                self.track.push((at, pose));
            }
            ("World", "scene") => self.scene = message::scene(&of(sample)),
            ("Adapter", "adapted") => self.paths.push((at, of(sample))),
            ("Adapter", "obstacles") => {
                let points = of::<asmotion_messages::Obstacles>(sample).points;
                self.obstacles = points.iter().map(message::vertex).collect();
            }
            ("Follower", "twist") => self.twists.push((at, of(sample))),
            ("Monitor", "twist") => self.passed.push((at, of(sample))),
            ("Rover", "wheels") => self.wheels.push((at, of(sample))),
            (_, "event") => {
                let event: asmotion_messages::Event = of(sample);
                self.events.push((at, event.code, event.detail));
            }
            _ => {}
        }
    }

    /// The codes of the events, in order.
    pub fn codes(&self) -> Vec<&str> {
        self.events
            .iter()
            .map(|(_, code, _)| code.as_str())
            .collect()
    }

    /// The robot's position at the end.
    pub fn end(&self) -> Point {
        let (_, pose) = self.track.last().unwrap();
        pose.translation.vector.into()
    }

    /// The time of an event, s.
    pub fn at(&self, code: &str) -> f64 {
        self.events.iter().find(|event| event.1 == code).unwrap().0
    }

    /// The robot's position at a time.
    pub fn place(&self, seconds: f64) -> Point {
        let after = self.track.partition_point(|(at, _)| *at < seconds);
        self.track[after].1.translation.vector.into()
    }

    /// The time, s, from which the wheels are commanded to stand still until the end; it is after `seconds`.
    pub fn wheels_stand_from(&self, seconds: f64) -> f64 {
        let turns = |(_, wheels): &(f64, WheelSpeeds)| (wheels.left, wheels.right) != (0.0, 0.0);
        let last = self.wheels.iter().rposition(turns).unwrap();
        let (at, _) = self.wheels[last + 1];
        assert!(at > seconds, "the wheels stood still before, at {at} s");
        at
    }
}

/// A disc that appears at time `at` and stays.
pub fn disc(at: f64, x: f64, y: f64, radius: f64) -> Obstacle {
    Obstacle {
        at_s: at,
        disc: Some([x, y, radius]),
        ..Obstacle::default()
    }
}

/// A block that appears at time `at` and stays.
pub fn block(at: f64, x: f64, y: f64, length: f64, width: f64) -> Obstacle {
    Obstacle {
        at_s: at,
        block: Some([x, y, length, width, 0.0]),
        ..Obstacle::default()
    }
}

/// Converts seconds to nanoseconds.
pub fn nanos(seconds: f64) -> i64 {
    (seconds * 1e9).round() as i64
}

fn obstacles(all: &[Obstacle]) -> Datum {
    Datum::List(
        all.iter()
            .map(|obstacle| Datum::of(obstacle).unwrap())
            .collect(),
    )
}

fn of<T: Message>(sample: &dyn Sample) -> T {
    sample.downcast_ref::<T>().unwrap().clone()
}

fn set(system: &mut System, component: &str, property: &str, value: Datum) {
    let id = system.id(component).unwrap();
    system.set_property(id, property, &value).unwrap();
}

fn add<C: Component + 'static>(
    system: &mut System,
    name: &str,
    period: u64,
    new: fn(&mut Interface) -> C,
) {
    let boxed = |interface: &mut Interface| Box::new(new(interface)) as Box<dyn Component>;
    system
        .add(name, Activity::periodic(period.ms()), boxed)
        .unwrap();
}
