//! The component: the scene and the true pose in, a scan out.

use std::f64::consts::PI;

use asmotion_component::{Component, Cycle, Fault, Flow, In, Interface, Out, Property, Setup};
use asmotion_geometry::{Point, Pose, Scene, heading, message};
use asmotion_messages::{Header, LaserScan, PoseStamped};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

use crate::sweep::Optics;

/// `nav::sim::LaserDriver`: a sweep each cycle, as soon as the scene and a new true pose are known.
pub struct LaserDriver {
    scene: In<asmotion_messages::Scene>,
    truth: In<PoseStamped>,
    scan: Out<LaserScan>,
    settings: Settings,

    optics: Optics,
    /// The laser on the robot.
    mount: Pose,
    frame: String,
    chance: ChaCha8Rng,
    surroundings: Option<Scene>,
    /// When the last sweep was, ns.
    last: Option<i64>,
}

struct Settings {
    seed: Property<u64>,
    noise: Property<f64>,
    dropout: Property<f64>,
    beams: Property<u32>,
    angle_min: Property<f64>,
    angle_max: Property<f64>,
    range_min: Property<f64>,
    range_max: Property<f64>,
    mount: Property<[f64; 3]>,
    frame: Property<String>,
}

/// The stream of random numbers that is the laser's: a world with the same seed draws others.
const STREAM: u64 = 1;

impl LaserDriver {
    /// Declares ports and properties.
    pub fn new(interface: &mut Interface) -> Self {
        Self {
            scene: interface.input("scene", "what a beam can hit, map frame"),
            truth: interface.input("truth", "where the robot truly is, map frame"),
            scan: interface.output(
                "scan",
                "a sweep for every new pose; REP-117 for what is no range",
            ),
            settings: Settings::declare(interface),
            optics: Optics::default(),
            mount: Pose::identity(),
            frame: String::new(),
            chance: ChaCha8Rng::seed_from_u64(0),
            surroundings: None,
            last: None,
        }
    }
}

impl Component for LaserDriver {
    fn configure(&mut self, setup: &mut Setup<'_>) -> Result<(), Fault> {
        self.optics = self.settings.optics(setup);
        let [x, y, yaw] = setup.property(self.settings.mount);
        self.mount = heading(Point::new(x, y), yaw);
        self.frame = setup.property(self.settings.frame);
        self.chance = ChaCha8Rng::seed_from_u64(setup.property(self.settings.seed));
        self.chance.set_stream(STREAM);
        if self.optics.range_min >= self.optics.range_max {
            return Err(Fault::new("`range_min` must be below `range_max`"));
        }
        Ok(())
    }

    fn start(&mut self) -> Result<(), Fault> {
        self.last = None;
        Ok(())
    }

    fn update(&mut self, cycle: &mut Cycle<'_>) -> Result<(), Fault> {
        if let Flow::NewData(scene) = cycle.read(self.scene) {
            self.surroundings = Some(message::scene(scene));
        }
        let (Flow::NewData(truth), Some(scene)) = (cycle.read(self.truth), &self.surroundings)
        else {
            return Ok(());
        };
        let stamp = truth.header.stamp;
        let nanos = stamp.as_nanos();
        let pose = message::pose(&truth.pose) * self.mount;
        let mut ranges = Vec::with_capacity(self.optics.beams);
        self.optics
            .sweep(scene, &pose, &mut self.chance, &mut ranges);
        let scan = LaserScan {
            header: Header {
                stamp,
                frame_id: self.frame.clone(),
            },
            angle_min: self.optics.angle_min as f32,
            angle_max: self.optics.angle_max as f32,
            angle_increment: self.optics.increment() as f32,
            time_increment: 0.0,
            scan_time: self.last.map_or(0.0, |last| (nanos - last) as f32 * 1e-9),
            range_min: self.optics.range_min as f32,
            range_max: self.optics.range_max as f32,
            ranges,
            intensities: Vec::new(),
        };
        self.last = Some(nanos);
        cycle.write(self.scan, scan);
        Ok(())
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
            noise: number(
                "noise_m",
                0.01,
                0.0,
                10.0,
                "m",
                "standard deviation of a range",
            ),
            dropout: number(
                "dropout",
                0.0,
                0.0,
                1.0,
                "",
                "share of beams whose measurement fails (NaN)",
            ),
            angle_min: number(
                "angle_min",
                -PI,
                -2.0 * PI,
                2.0 * PI,
                "rad",
                "the first beam; 0 is straight ahead",
            ),
            angle_max: number("angle_max", PI, -2.0 * PI, 2.0 * PI, "rad", "the last beam"),
            range_min: number(
                "range_min",
                0.05,
                0.0,
                1000.0,
                "m",
                "what is nearer reads -Inf",
            ),
            range_max: number(
                "range_max",
                8.0,
                0.0,
                1000.0,
                "m",
                "what is farther reads +Inf",
            ),
            beams: interface
                .setting(
                    "beams",
                    721,
                    "how many beams from the first angle to the last",
                )
                .range(1..=100_000)
                .declare(),
            seed: interface.property("seed", 1, "the same seed gives the same noise"),
            mount: interface.property(
                "mount",
                [0.0; 3],
                "the laser on the robot: x m, y m, yaw rad, base frame",
            ),
            frame: interface.property("frame", "laser".to_owned(), "the laser's own frame"),
        }
    }

    fn optics(&self, setup: &Setup<'_>) -> Optics {
        Optics {
            beams: setup.property(self.beams) as usize,
            angle_min: setup.property(self.angle_min),
            angle_max: setup.property(self.angle_max),
            range_min: setup.property(self.range_min),
            range_max: setup.property(self.range_max),
            noise: setup.property(self.noise),
            dropout: setup.property(self.dropout),
        }
    }
}
