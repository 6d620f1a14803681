//! The component: reads the scene and the true pose, writes a scan.

use asmotion_component::{
    Component, Cycle, Fault, Flow, Freeze, In, Interface, Out, Ports, Properties, PropertySet,
    Setup, freeze_by_fields,
};
use asmotion_geometry::{ObstacleScene, Point, Pose, heading, message};
use asmotion_messages::{
    Header, LaserScan, PoseStamped, RoverDiscs, Transform, TransformStamped, Vector3,
};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

use crate::sweep::Optics;

/// `nav::sim::LaserDriver`: writes a sweep for each new true pose, once the scene is known.
#[derive(Freeze)]
#[freeze(component = "nav::sim::LaserDriver", version = 2)]
pub struct LaserDriver {
    #[freeze(skip)]
    ports: LaserPorts,
    /// Read when configured.
    properties: PropertySet<LaserProperties>,

    /// Pose of the laser on the robot.
    mount: Pose,
    chance: ChaCha8Rng,
    surroundings: Option<ObstacleScene>,
    /// The other robots.
    rovers: ObstacleScene,
    /// Stamp of the last sweep, ns.
    last: Option<i64>,
}

#[derive(Ports)]
struct LaserPorts {
    /// Everything a beam can hit, map frame.
    scene: In<asmotion_messages::Scene>,
    /// Places of all robots of the world, which `nav::sim::Traffic` collects.
    #[port(optional)]
    rovers: In<RoverDiscs>,
    /// True pose of the robot, map frame.
    truth: In<PoseStamped>,
    /// One sweep for each new pose, with its stamp; ranges in m, REP-117 values for beams without a range.
    scan: Out<LaserScan>,
    /// Pose of the laser in the frame of the robot, once, before the first sweep.
    mounting: Out<TransformStamped>,
}

#[derive(Properties)]
struct LaserProperties {
    #[property(flatten)]
    optics: Optics,
    /// Seed of the noise: the same seed gives the same noise.
    #[property(default = 1)]
    seed: u64,
    /// Name of its own robot, which no beam hits; empty if it is the only one.
    rover: String,
    /// Pose of the laser on the robot: x m, y m, yaw rad, base frame.
    mount: [f64; 3],
    /// Frame of the laser.
    #[property(default = "laser")]
    frame: String,
    /// Frame of the robot, in which the laser is mounted.
    #[property(default = "base_link")]
    base_frame: String,
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
            rovers: ObstacleScene::default(),
            last: None,
        }
    }
}

impl LaserDriver {
    /// Pose of the laser in the frame of the robot.
    fn mounting(&self, nanos: i64) -> TransformStamped {
        let pose = message::pose_message(&self.mount);
        TransformStamped {
            header: Header::new(nanos, &self.properties.base_frame),
            child_frame_id: self.properties.frame.clone(),
            transform: Transform {
                translation: Vector3 {
                    x: pose.position.x,
                    y: pose.position.y,
                    z: pose.position.z,
                },
                rotation: pose.orientation,
            },
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
        let LaserProperties {
            optics,
            frame,
            rover: own,
            ..
        } = &*self.properties;
        if let Flow::NewData(scene) = cycle.read(self.ports.scene) {
            self.surroundings = Some(message::scene(scene));
        }
        if let Flow::NewData(known) = cycle.read(self.ports.rovers) {
            let others = known.rovers.iter().filter(|it| it.rover != *own);
            let discs = others.map(|it| message::disc(&it.disc)).collect();
            self.rovers = ObstacleScene::new(Vec::new(), Vec::new(), discs);
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
        let scenes = [scene, &self.rovers];
        optics.sweep(scenes, &pose, &mut self.chance, &mut ranges);
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
        let mounting = self.last.is_none().then(|| self.mounting(nanos));
        self.last = Some(nanos);
        if let Some(mounting) = mounting {
            cycle.write(self.ports.mounting, mounting);
        }
        cycle.write(self.ports.scan, scan);
        Ok(())
    }
}
