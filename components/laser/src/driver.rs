//! The component: reads the scene and the true pose, writes a scan.

use asmotion_component::{
    Component, Cycle, Fault, Flow, Freeze, In, Interface, Out, Ports, Properties, PropertySet,
    Setup, freeze_by_fields,
};
use asmotion_geometry::{ObstacleScene, Point, Pose, heading, message};
use asmotion_messages::{Header, LaserScan, PoseStamped};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

use crate::sweep::Optics;

/// `nav::sim::LaserDriver`: writes a sweep for each new true pose, once the scene is known.
#[derive(Freeze)]
#[freeze(component = "nav::sim::LaserDriver", version = 1)]
pub struct LaserDriver {
    #[freeze(skip)]
    ports: LaserPorts,
    /// Read when configured.
    properties: PropertySet<LaserProperties>,

    /// Pose of the laser on the robot.
    mount: Pose,
    chance: ChaCha8Rng,
    surroundings: Option<ObstacleScene>,
    /// Stamp of the last sweep, ns.
    last: Option<i64>,
}

#[derive(Ports)]
struct LaserPorts {
    /// Everything a beam can hit, map frame.
    scene: In<asmotion_messages::Scene>,
    /// True pose of the robot, map frame.
    truth: In<PoseStamped>,
    /// One sweep for each new pose, with its stamp; ranges in m, REP-117 values for beams without a range.
    scan: Out<LaserScan>,
}

#[derive(Properties)]
struct LaserProperties {
    #[property(flatten)]
    optics: Optics,
    /// Seed of the noise: the same seed gives the same noise.
    #[property(default = 1)]
    seed: u64,
    /// Pose of the laser on the robot: x m, y m, yaw rad, base frame.
    mount: [f64; 3],
    /// Frame of the laser.
    #[property(default = "laser")]
    frame: String,
}

/// Random number stream of the laser; a world with the same seed uses another one.
const STREAM: u64 = 1;

impl LaserDriver {
    /// Declares ports and properties.
    pub fn new(interface: &mut Interface) -> Self {
        Self {
            ports: interface.ports(),
            properties: interface.properties(),
            mount: Pose::identity(),
            chance: ChaCha8Rng::seed_from_u64(0),
            surroundings: None,
            last: None,
        }
    }
}

impl Component for LaserDriver {
    freeze_by_fields!();

    fn configure(&mut self, setup: &mut Setup<'_>) -> Result<(), Fault> {
        let LaserProperties {
            optics,
            seed,
            mount: [x, y, yaw],
            ..
        } = self.properties.refresh(setup);
        self.mount = heading(Point::new(*x, *y), *yaw);
        self.chance = ChaCha8Rng::seed_from_u64(*seed);
        self.chance.set_stream(STREAM);
        if optics.range_min >= optics.range_max {
            return Err(Fault::new("`range_min` must be below `range_max`"));
        }
        Ok(())
    }

    fn start(&mut self) -> Result<(), Fault> {
        self.last = None;
        Ok(())
    }

    fn update(&mut self, cycle: &mut Cycle<'_>) -> Result<(), Fault> {
        let LaserProperties { optics, frame, .. } = &*self.properties;
        if let Flow::NewData(scene) = cycle.read(self.ports.scene) {
            self.surroundings = Some(message::scene(scene));
        }
        let (Flow::NewData(truth), Some(scene)) =
            (cycle.read(self.ports.truth), &self.surroundings)
        else {
            return Ok(());
        };
        let stamp = truth.header.stamp;
        let nanos = stamp.as_nanos();
        let pose = message::pose(&truth.pose) * self.mount;
        let mut ranges = Vec::with_capacity(optics.beams as usize);
        optics.sweep(scene, &pose, &mut self.chance, &mut ranges);
        let scan = LaserScan {
            header: Header {
                stamp,
                frame_id: frame.clone(),
            },
            angle_min: optics.angle_min as f32,
            angle_max: optics.angle_max as f32,
            angle_increment: optics.increment() as f32,
            time_increment: 0.0,
            scan_time: self.last.map_or(0.0, |last| (nanos - last) as f32 * 1e-9),
            range_min: optics.range_min as f32,
            range_max: optics.range_max as f32,
            ranges,
            intensities: Vec::new(),
        };
        self.last = Some(nanos);
        cycle.write(self.ports.scan, scan);
        Ok(())
    }
}
