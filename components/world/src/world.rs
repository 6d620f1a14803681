//! The component: wheel speeds in; encoders, the true pose and the scene out.

use asmotion_component::{Component, Cycle, Fault, Flow, In, Interface, Out, Property, Setup};
use asmotion_geometry::{Point, Pose, Scene, heading, message};
use asmotion_map::Disk;
use asmotion_messages::{Encoders, Event, PoseStamped, Time, WheelSpeeds};
use asmotion_rover::Drive;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

use crate::body::{Body, Slip};
use crate::schedule::{Obstacle, Schedule, Solid};

/// `nav::sim::World`: one robot among walls and obstacles that come and go.
pub struct World {
    wheels: In<WheelSpeeds>,
    encoders: Out<Encoders>,
    truth: Out<PoseStamped>,
    scene: Out<asmotion_messages::Scene>,
    event: Out<Event>,
    settings: Settings,

    truth_of: Truth,
    chance: ChaCha8Rng,
    slip: f64,
    wheel_timeout: i64,
    frame: String,
    /// What the wheels were told, and when (ns).
    told: Option<(WheelSpeeds, i64)>,
    /// ns, of the first cycle: the schedule counts from there.
    began: Option<i64>,
    /// ns, of the last cycle.
    last: i64,
}

/// What is where.
#[derive(Debug, Clone)]
struct Truth {
    body: Body,
    walls: Scene,
    schedule: Schedule,
    scene: Scene,
    revision: u64,
    /// Whether the body touches something; said once until it is free again.
    touches: bool,
}

struct Settings {
    seed: Property<u64>,
    floor_plan: Property<String>,
    walls: Property<Vec<f64>>,
    obstacles: Property<Vec<Obstacle>>,
    start: Property<[f64; 3]>,
    wheel_radius: Property<f64>,
    track: Property<f64>,
    robot_radius: Property<f64>,
    slip: Property<f64>,
    wheel_timeout: Property<f64>,
    frame: Property<String>,
}

/// The stream of random numbers that is the world's: a laser with the same seed draws others.
const STREAM: u64 = 0;

/// s, the longest time that is computed in one go: the body then moves less than its own size.
const STEP: f64 = 0.02;

/// m, the body counts as free of a thing again from this far.
const FREE: f64 = 0.01;

impl World {
    /// Declares ports and properties.
    pub fn new(interface: &mut Interface) -> Self {
        let settings = Settings::declare(interface);
        Self {
            wheels: interface.input("wheels", "how fast the motors turn the wheels"),
            encoders: interface.output("encoders", "how far the wheels have turned, every cycle"),
            truth: interface.output("truth", "where the robot truly is, map frame, every cycle"),
            scene: interface.output("scene", "what stands where, map frame, whenever it changes"),
            event: interface.output("event", "COLLISION once a touch"),
            settings,
            truth_of: Truth::default(),
            chance: ChaCha8Rng::seed_from_u64(0),
            slip: 0.0,
            wheel_timeout: 0,
            frame: String::new(),
            told: None,
            began: None,
            last: 0,
        }
    }

    /// How fast the wheels turn now. Motors that hear nothing stop by themselves.
    fn turning(&mut self, cycle: &Cycle<'_>, now: i64) -> WheelSpeeds {
        if let Flow::NewData(wheels) = cycle.read(self.wheels) {
            self.told = Some((*wheels, now));
        }
        match self.told {
            Some((wheels, at)) if now - at <= self.wheel_timeout && is_number(wheels) => wheels,
            _ => WheelSpeeds::default(),
        }
    }

    /// Lets `dt` seconds pass; says whether the body now touches something that it did not touch before.
    fn pass(&mut self, wheels: WheelSpeeds, dt: f64) -> bool {
        let pieces = (dt / STEP - 1e-6).ceil().clamp(1.0, 1000.0);
        let mut bumped = false;
        for _ in 0..pieces as u32 {
            let slip = Slip {
                left: self.draw_slip(),
                right: self.draw_slip(),
            };
            bumped |= self.truth_of.pass(wheels, slip, dt / pieces);
        }
        bumped
    }

    fn draw_slip(&mut self) -> f64 {
        let normal: f64 = StandardNormal.sample(&mut self.chance);
        normal * self.slip
    }
}

fn is_number(wheels: WheelSpeeds) -> bool {
    wheels.left.is_finite() && wheels.right.is_finite()
}

impl Component for World {
    fn configure(&mut self, setup: &mut Setup<'_>) -> Result<(), Fault> {
        self.truth_of = self.settings.truth(setup)?;
        self.slip = setup.property(self.settings.slip);
        self.wheel_timeout = (setup.property(self.settings.wheel_timeout) * 1e9) as i64;
        self.frame = setup.property(self.settings.frame);
        self.chance = ChaCha8Rng::seed_from_u64(setup.property(self.settings.seed));
        self.chance.set_stream(STREAM);
        self.told = None;
        self.began = None;
        Ok(())
    }

    fn update(&mut self, cycle: &mut Cycle<'_>) -> Result<(), Fault> {
        let now = cycle.now().nanos();
        let first = self.began.is_none();
        let began = *self.began.get_or_insert(now);
        let dt = if first {
            0.0
        } else {
            (now - self.last) as f64 * 1e-9
        };
        self.last = now;

        let wheels = self.turning(cycle, now);
        let bumped = self.pass(wheels, dt);
        let changed = self.truth_of.advance((now - began) as f64 * 1e-9);

        let body = &self.truth_of.body;
        cycle.write(
            self.encoders,
            Encoders {
                stamp: Time::from_nanos(now),
                left: body.left,
                right: body.right,
            },
        );
        cycle.write(
            self.truth,
            message::pose_stamped(&body.pose, now, &self.frame),
        );
        if changed || first {
            cycle.write(
                self.scene,
                message::scene_message(&self.truth_of.scene, self.truth_of.revision),
            );
        }
        if bumped {
            let place = body.pose.translation;
            let detail = format!("at ({:.2}, {:.2})", place.x, place.y);
            cycle.write(self.event, Event::new(now, Event::COLLISION, detail));
        }
        Ok(())
    }
}

impl Default for Truth {
    fn default() -> Self {
        let drive = Drive {
            wheel_radius: 1.0,
            track: 1.0,
        };
        Self::new(
            Body::new(drive, 0.0, Pose::identity()),
            Scene::default(),
            Schedule::default(),
        )
    }
}

impl Truth {
    fn new(body: Body, walls: Scene, schedule: Schedule) -> Self {
        Self {
            body,
            scene: walls.clone(),
            walls,
            schedule,
            revision: 1,
            touches: false,
        }
    }

    /// Moves the body; says whether it now touches something that it did not touch before.
    fn pass(&mut self, wheels: WheelSpeeds, slip: Slip, dt: f64) -> bool {
        let touched = self.body.step(wheels, slip, &self.scene, dt);
        let bumped = touched && !self.touches;
        self.touches = touched || (self.touches && self.body.clearance(&self.scene) < FREE);
        bumped
    }

    /// Lets obstacles come and go; says whether any did.
    fn advance(&mut self, seconds: f64) -> bool {
        let changed = self
            .schedule
            .advance(seconds, &self.body.pose, self.body.radius);
        if changed {
            self.revision += 1;
            let mut polygons = self.walls.polygons().to_vec();
            let mut discs = self.walls.discs().to_vec();
            for solid in self.schedule.there() {
                match solid {
                    Solid::Disc(disc) => discs.push(*disc),
                    Solid::Polygon(corners) => polygons.push(corners.clone()),
                }
            }
            self.scene = Scene::new(self.walls.segments().to_vec(), polygons, discs);
        }
        changed
    }
}

impl Settings {
    fn declare(interface: &mut Interface) -> Self {
        let mut number =
            |name: &str, default: f64, least: f64, most: f64, unit: &str, doc: &str| {
                let setting = interface.setting(name, default, doc);
                setting.range(least..=most).unit(unit).declare()
            };
        Self {
            wheel_radius: number("wheel_radius_m", 0.05, 0.001, 1.0, "m", "radius of a wheel"),
            track: number("track_m", 0.3, 0.01, 5.0, "m", "between the two wheels"),
            robot_radius: number("robot_radius_m", 0.2, 0.0, 10.0, "m", "of the disc that covers the robot"),
            slip: number("slip", 0.0005, 0.0, 0.5, "", "standard deviation of how much farther a wheel rolls in a cycle, as a share"),
            wheel_timeout: number("wheel_timeout_s", 0.5, 0.0, 10.0, "s", "after so long without new wheel speeds the motors stop"),
            start: interface.property("start", [0.0; 3], "where the robot stands at the beginning: x m, y m, yaw rad"),
            floor_plan: interface.property("floor_plan", String::new(), "the file of the map whose occupied cells are walls; none without"),
            walls: interface.property("walls", Vec::new(), "more walls: x1, y1, x2, y2 of each, m"),
            obstacles: interface.property("obstacles", Vec::new(), "what no map shows: at_s, until_s, disc = [x, y, radius] or block = [x, y, length, width, yaw], frame = \"map\" or \"robot\""),
            seed: interface.property("seed", 1, "the same seed gives the same slip"),
            frame: interface.property("frame", "map".to_owned(), "the frame of everything here"),
        }
    }

    /// The world at the beginning.
    fn truth(&self, setup: &Setup<'_>) -> Result<Truth, Fault> {
        let [x, y, yaw] = setup.property(self.start);
        let drive = Drive {
            wheel_radius: setup.property(self.wheel_radius),
            track: setup.property(self.track),
        };
        let radius = setup.property(self.robot_radius);
        let body = Body::new(drive, radius, heading(Point::new(x, y), yaw));
        let obstacles = setup.property(self.obstacles);
        Ok(Truth::new(
            body,
            self.static_walls(setup)?,
            Schedule::new(obstacles)?,
        ))
    }

    fn static_walls(&self, setup: &Setup<'_>) -> Result<Scene, Fault> {
        let file = setup.property(self.floor_plan);
        let plan = match file.strip_prefix("file:").unwrap_or(&file) {
            "" => Scene::default(),
            name => asmotion_map::load(&Disk, name, &asmotion_map::Settings::default())?.scene(),
        };
        let numbers = setup.property(self.walls);
        let (more, rest) = numbers.as_chunks::<4>();
        if !rest.is_empty() {
            return Err(Fault::new(
                "`walls` needs four numbers a wall: x1, y1, x2, y2",
            ));
        }
        let more = more
            .iter()
            .map(|[x1, y1, x2, y2]| [Point::new(*x1, *y1), Point::new(*x2, *y2)]);
        let segments = plan.segments().iter().copied().chain(more).collect();
        Ok(Scene::new(
            segments,
            plan.polygons().to_vec(),
            plan.discs().to_vec(),
        ))
    }
}
