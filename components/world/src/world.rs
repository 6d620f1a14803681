//! The component: reads wheel speeds; writes encoders, the true pose and the scene.

use std::time::Duration;

use asmotion_component::{
    Component, Cycle, Fault, Flow, Freeze, In, Interface, Out, Ports, Properties, PropertySet,
    Setup, Time, freeze_by_fields,
};
use asmotion_geometry::{ObstacleScene, Point, Pose, heading, message};
use asmotion_map::DiskFiles;
use asmotion_messages::{
    Disc, Encoders, Event, PoseStamped, RoverDisc, RoverDiscs, Time as Stamp, WheelSpeeds,
};
use asmotion_rover::DifferentialDrive;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use serde::{Deserialize, Serialize};

use crate::body::{Body, Slip, Surroundings, distance, position};
use crate::schedule::{Obstacle, Schedule, Solid};

/// `nav::sim::World`: one robot among walls, scheduled obstacles and other robots.
#[derive(Freeze)]
#[freeze(component = "nav::sim::World", version = 2)]
pub struct World {
    #[freeze(skip)]
    ports: WorldPorts,
    /// Read when configured.
    properties: PropertySet<WorldProperties>,

    truth: Truth,
    chance: ChaCha8Rng,
    /// The newest wheel speeds, and the time at which they arrived.
    commanded: Option<(WheelSpeeds, Time)>,
    /// Time of the first cycle, from which the schedule counts.
    began: Option<Time>,
    /// Time of the last cycle.
    last: Time,
}

/// State of the world.
#[derive(Debug, Clone, Serialize, Deserialize)]
#[serde(from = "FrozenTruth")]
struct Truth {
    body: Body,
    walls: ObstacleScene,
    schedule: Schedule,
    /// Walls and obstacles currently present.
    #[serde(skip_serializing)]
    scene: ObstacleScene,
    revision: u64,
    /// The other robots nearby.
    rovers: Vec<RoverDisc>,
    /// `true` while the body touches an obstacle; the collision is reported once until it is free again.
    touches: bool,
}

/// Serialised form of the world; the scene is derived from the walls and the schedule.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct FrozenTruth {
    body: Body,
    walls: ObstacleScene,
    schedule: Schedule,
    revision: u64,
    rovers: Vec<RoverDisc>,
    touches: bool,
}

impl From<FrozenTruth> for Truth {
    fn from(frozen: FrozenTruth) -> Self {
        let FrozenTruth {
            body,
            walls,
            schedule,
            revision,
            rovers,
            touches,
        } = frozen;
        let mut truth = Self::new(body, walls, schedule);
        truth.update_scene();
        Self {
            revision,
            rovers,
            touches,
            ..truth
        }
    }
}

#[derive(Ports)]
struct WorldPorts {
    /// Speeds at which the motors turn the wheels, rad/s.
    wheels: In<WheelSpeeds>,
    /// Places of all robots of the world, which `nav::sim::Traffic` collects.
    #[port(optional)]
    rovers: In<RoverDiscs>,
    /// Angles by which the wheels have turned, rad, every cycle.
    encoders: Out<Encoders>,
    /// True pose of the robot, map frame, every cycle.
    truth: Out<PoseStamped>,
    /// Place of the robot, every cycle if it has a name (`rover`).
    disc: Out<RoverDisc>,
    /// Walls and obstacles, map frame, at the start and whenever they change; `revision` grows.
    scene: Out<asmotion_messages::Scene>,
    /// `COLLISION`, once per contact; `detail` names the other robot, if it is one.
    event: Out<Event>,
}

#[derive(Properties)]
struct WorldProperties {
    #[property(flatten)]
    drive: DifferentialDrive,
    /// Name among the robots of the world; empty if it is the only one.
    rover: String,
    /// Radius of the robot's disc.
    #[property(unit = "m", range = 0.0..=10.0, default = 0.2)]
    robot_radius_m: f64,
    /// Standard deviation of a wheel's slip in a cycle, as a fraction of the distance rolled.
    #[property(range = 0.0..=0.5, default = 0.0005)]
    slip: f64,
    /// Time without new wheel speeds after which the motors stop.
    #[property(range = "0s"..="10s", default = "500ms")]
    wheel_timeout_s: Duration,
    /// Pose of the robot at the start: x m, y m, yaw rad, map frame.
    start: [f64; 3],
    /// Map file, of any format of the map server, whose occupied cells are walls; empty for none.
    floor_plan: String,
    /// Additional walls: x1, y1, x2, y2 of each, m, map frame.
    walls: Vec<f64>,
    /// Obstacles that no map shows: `at_s`, `until_s`, `disc = [x, y, radius]` or `block = [x, y, length, width, yaw]`,
    /// `frame = "map"` or `"robot"`; m and rad.
    obstacles: Vec<Obstacle>,
    /// Seed of the slip: the same seed gives the same slip.
    #[property(default = 1)]
    seed: u64,
    /// Name of the map frame.
    #[property(default = "map")]
    frame: String,
}

/// Random number stream of the world; a laser with the same seed uses another one.
const STREAM: u64 = 0;

/// Largest time step in s, in which the body moves less than its own size.
const STEP: f64 = 0.02;

/// Distance in m up to which other robots are considered: more than both can drive until the next sample.
const NEARBY: f64 = 2.0;

/// Distance in m from which the body counts as free of an obstacle again.
const FREE: f64 = 0.01;

impl World {
    /// Declares ports and properties.
    pub fn new(interface: &mut Interface) -> Self {
        Self {
            ports: interface.ports(),
            properties: interface.properties(),
            truth: Truth::default(),
            chance: ChaCha8Rng::seed_from_u64(0),
            commanded: None,
            began: None,
            last: Time::ZERO,
        }
    }

    /// Speeds of the wheels in this cycle, rad/s; zero once the newest command is too old.
    fn turning(&mut self, cycle: &Cycle<'_>, now: Time) -> WheelSpeeds {
        if let Flow::NewData(wheels) = cycle.read(self.ports.wheels) {
            self.commanded = Some((*wheels, now));
        }
        let timeout = self.properties.wheel_timeout_s;
        match self.commanded {
            Some((wheels, at)) if now.since(at) <= timeout && is_number(wheels) => wheels,
            _ => WheelSpeeds::default(),
        }
    }

    /// Reads where the other robots are, and keeps those nearby.
    fn look_around(&mut self, cycle: &Cycle<'_>) {
        let Flow::NewData(known) = cycle.read(self.ports.rovers) else {
            return;
        };
        let (own, body) = (&self.properties.rover, &self.truth.body);
        let place = position(&body.pose);
        let is_near =
            |it: &&RoverDisc| it.rover != *own && distance(it, place) - body.radius < NEARBY;
        self.truth.rovers = known.rovers.iter().filter(is_near).cloned().collect();
    }

    /// The robot as others see it; `None` if it has no name.
    fn disc(&self) -> Option<RoverDisc> {
        let rover = &self.properties.rover;
        let body = &self.truth.body;
        let at = position(&body.pose);
        (!rover.is_empty()).then(|| RoverDisc {
            rover: rover.clone(),
            disc: Disc {
                x: at.x,
                y: at.y,
                radius: body.radius,
            },
        })
    }

    /// Advances the world by `dt` seconds; returns whether the body has begun to touch something.
    fn pass(&mut self, wheels: WheelSpeeds, dt: f64) -> bool {
        let pieces = (dt / STEP - 1e-6).ceil().clamp(1.0, 1000.0);
        let mut bumped = false;
        for _ in 0..pieces as u32 {
            let slip = Slip {
                left: self.draw_slip(),
                right: self.draw_slip(),
            };
            bumped |= self.truth.pass(wheels, slip, dt / pieces);
        }
        bumped
    }

    fn draw_slip(&mut self) -> f64 {
        let normal: f64 = StandardNormal.sample(&mut self.chance);
        normal * self.properties.slip
    }
}

/// Seconds from one cycle to a later one.
fn seconds(from: Time, to: Time) -> f64 {
    (to.nanos() - from.nanos()) as f64 * 1e-9
}

fn is_number(wheels: WheelSpeeds) -> bool {
    wheels.left.is_finite() && wheels.right.is_finite()
}

impl Component for World {
    freeze_by_fields!();

    fn configure(&mut self, setup: &mut Setup<'_>) -> Result<(), Fault> {
        let properties = self.properties.refresh(setup);
        self.truth = properties.truth()?;
        self.chance = ChaCha8Rng::seed_from_u64(properties.seed);
        self.chance.set_stream(STREAM);
        self.commanded = None;
        self.began = None;
        Ok(())
    }

    fn update(&mut self, cycle: &mut Cycle<'_>) -> Result<(), Fault> {
        let now = cycle.now();
        let first = self.began.is_none();
        let began = *self.began.get_or_insert(now);
        let dt = if first { 0.0 } else { seconds(self.last, now) };
        self.last = now;

        self.look_around(cycle);
        let wheels = self.turning(cycle, now);
        let bumped = self.pass(wheels, dt);
        let changed = self.truth.advance(seconds(began, now));

        let body = &self.truth.body;
        cycle.write(
            self.ports.encoders,
            Encoders {
                stamp: Stamp::from_nanos(now.nanos()),
                left: body.left,
                right: body.right,
            },
        );
        cycle.write(
            self.ports.truth,
            message::pose_stamped(&body.pose, now.nanos(), &self.properties.frame),
        );
        if let Some(disc) = self.disc() {
            cycle.write(self.ports.disc, disc);
        }
        if changed || first {
            cycle.write(
                self.ports.scene,
                message::scene_message(&self.truth.scene, self.truth.revision),
            );
        }
        if bumped {
            let event = Event::new(now.nanos(), Event::COLLISION, self.truth.contact());
            cycle.write(self.ports.event, event);
        }
        Ok(())
    }
}

impl Default for Truth {
    fn default() -> Self {
        let drive = DifferentialDrive {
            wheel_radius_m: 1.0,
            track_m: 1.0,
        };
        Self::new(
            Body::new(drive, 0.0, Pose::identity()),
            ObstacleScene::default(),
            Schedule::default(),
        )
    }
}

impl Truth {
    fn new(body: Body, walls: ObstacleScene, schedule: Schedule) -> Self {
        Self {
            body,
            scene: walls.clone(),
            walls,
            schedule,
            revision: 1,
            rovers: Vec::new(),
            touches: false,
        }
    }

    /// Moves the body; returns whether it has begun to touch something.
    fn pass(&mut self, wheels: WheelSpeeds, slip: Slip, dt: f64) -> bool {
        let around = Surroundings {
            scene: &self.scene,
            rovers: &self.rovers,
        };
        let touched = self.body.step(wheels, slip, around, dt);
        let bumped = touched && !self.touches;
        self.touches = touched || (self.touches && self.body.clearance(around) < FREE);
        bumped
    }

    /// The obstacle that the body touches, and the place of contact.
    fn contact(&self) -> String {
        let at = position(&self.body.pose);
        let place = format!("at ({:.2}, {:.2})", at.x, at.y);
        // the body stops before it would touch, a step away at most
        let reach = self.body.radius + STEP;
        let mut rovers = self.rovers.iter();
        match rovers.find(|rover| distance(rover, at) < reach) {
            Some(other) => format!("with {} {place}", other.rover),
            None => place,
        }
    }

    /// Adds and removes obstacles by the schedule; returns whether the scene has changed.
    fn advance(&mut self, seconds: f64) -> bool {
        let changed = self
            .schedule
            .advance(seconds, &self.body.pose, self.body.radius);
        if changed {
            self.revision += 1;
            self.update_scene();
        }
        changed
    }

    /// Builds the scene from the walls and the obstacles currently present.
    fn update_scene(&mut self) {
        let mut polygons = self.walls.polygons().to_vec();
        let mut discs = self.walls.discs().to_vec();
        for solid in self.schedule.present() {
            match solid {
                Solid::Disc(disc) => discs.push(*disc),
                Solid::Polygon(corners) => polygons.push(corners.clone()),
            }
        }
        self.scene = ObstacleScene::new(self.walls.segments().to_vec(), polygons, discs);
    }
}

impl WorldProperties {
    /// The initial state of the world.
    fn truth(&self) -> Result<Truth, Fault> {
        let [x, y, yaw] = self.start;
        let body = Body::new(
            self.drive,
            self.robot_radius_m,
            heading(Point::new(x, y), yaw),
        );
        let schedule = Schedule::new(self.obstacles.clone())?;
        Ok(Truth::new(body, self.static_walls()?, schedule))
    }

    fn static_walls(&self) -> Result<ObstacleScene, Fault> {
        let file = &self.floor_plan;
        let plan = match file.strip_prefix("file:").unwrap_or(file) {
            "" => ObstacleScene::default(),
            name => {
                asmotion_map::load(&DiskFiles, name, &asmotion_map::MapSettings::default())?.scene()
            }
        };
        let (more, rest) = self.walls.as_chunks::<4>();
        if !rest.is_empty() {
            return Err(Fault::new(
                "`walls` needs four numbers a wall: x1, y1, x2, y2",
            ));
        }
        if more.is_empty() {
            return Ok(plan);
        }
        let more = more
            .iter()
            .map(|[x1, y1, x2, y2]| [Point::new(*x1, *y1), Point::new(*x2, *y2)]);
        let segments = plan.segments().iter().copied().chain(more).collect();
        Ok(ObstacleScene::new(
            segments,
            plan.polygons().to_vec(),
            plan.discs().to_vec(),
        ))
    }
}
