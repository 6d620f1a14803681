//! The component: twist in, wheel speeds out; encoders in, odometry out.

use asmotion_component::{Component, Cycle, Fault, Flow, In, Interface, Out, Property, Setup};
use asmotion_geometry::{Point, Pose, heading, message};
use asmotion_messages::{Encoders, Header, Odometry, Twist, WheelSpeeds};

use crate::drive::{Drive, Limits, Velocity};
use crate::odometry::Odometer;

/// `nav::sim::RoverDriver`: drives the wheels as the newest twist says, and not at all once it is old.
pub struct RoverDriver {
    twist: In<Twist>,
    encoders: In<Encoders>,
    wheels: Out<WheelSpeeds>,
    odom: Out<Odometry>,
    settings: Settings,

    odometer: Odometer,
    /// What the wheels were last told.
    velocity: Velocity,
    /// What the newest twist asks for, and when it came (ns).
    wanted: Option<(Velocity, i64)>,
    /// When the last cycle was, ns.
    last: Option<i64>,
}

struct Settings {
    wheel_radius: Property<f64>,
    track: Property<f64>,
    max_speed: Property<f64>,
    max_turn: Property<f64>,
    max_acceleration: Property<f64>,
    max_turn_acceleration: Property<f64>,
    max_wheel_speed: Property<f64>,
    command_timeout: Property<f64>,
    start: Property<[f64; 3]>,
    frame: Property<String>,
    base_frame: Property<String>,
}

impl RoverDriver {
    /// Declares ports and properties.
    pub fn new(interface: &mut Interface) -> Self {
        Self {
            twist: interface.input(
                "twist",
                "the velocity to drive: linear.x m/s, angular.z rad/s, base frame",
            ),
            encoders: interface.input("encoders", "how far the wheels have turned"),
            wheels: interface.output("wheels", "how fast the wheels shall turn, every cycle"),
            odom: interface.output(
                "odom",
                "where the wheels say that the robot is, for every reading of the encoders",
            ),
            settings: Settings::declare(interface),
            odometer: Odometer::new(Pose::identity()),
            velocity: Velocity::default(),
            wanted: None,
            last: None,
        }
    }

    /// The velocity for the next cycle. An old command counts as none; then the wheels stop at once, without a ramp.
    fn drive(&mut self, cycle: &mut Cycle<'_>, drive: &Drive, now: i64) {
        if let Flow::NewData(twist) = cycle.read(self.twist) {
            let wanted = Velocity {
                speed: twist.linear.x,
                turn: twist.angular.z,
            };
            self.wanted = Some((wanted, now));
        }
        let dt = self.last.map_or(0.0, |last| (now - last) as f64 * 1e-9);
        self.last = Some(now);
        let timeout = (cycle.property(self.settings.command_timeout) * 1e9) as i64;
        let stale = cycle.is_stale(self.twist);
        self.velocity = match self.wanted {
            Some((wanted, at)) if now - at < timeout && !stale => {
                let limits = self.settings.limits(cycle);
                limits.toward(drive, self.velocity, wanted, dt)
            }
            _ => {
                self.wanted = None;
                Velocity::default()
            }
        };
        cycle.write(self.wheels, drive.wheels(self.velocity));
    }

    /// Counts the wheels' turns.
    fn locate(&mut self, cycle: &mut Cycle<'_>, drive: &Drive) {
        let Flow::NewData(encoders) = cycle.read(self.encoders) else {
            return;
        };
        self.odometer.update(drive, encoders);
        let mut odometry = Odometry {
            header: Header {
                stamp: encoders.stamp,
                frame_id: cycle.property(self.settings.frame),
            },
            child_frame_id: cycle.property(self.settings.base_frame),
            ..Odometry::default()
        };
        let velocity = self.odometer.velocity();
        odometry.pose.pose = message::pose_message(self.odometer.pose());
        odometry.twist.twist = Twist::planar(velocity.speed, velocity.turn);
        cycle.write(self.odom, odometry);
    }
}

impl Component for RoverDriver {
    fn configure(&mut self, setup: &mut Setup<'_>) -> Result<(), Fault> {
        let [x, y, yaw] = setup.property(self.settings.start);
        self.odometer = Odometer::new(heading(Point::new(x, y), yaw));
        Ok(())
    }

    fn start(&mut self) -> Result<(), Fault> {
        self.velocity = Velocity::default();
        self.wanted = None;
        self.last = None;
        Ok(())
    }

    fn update(&mut self, cycle: &mut Cycle<'_>) -> Result<(), Fault> {
        let drive = self.settings.geometry(cycle);
        self.locate(cycle, &drive);
        self.drive(cycle, &drive, cycle.now().nanos());
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
            wheel_radius: number("wheel_radius_m", 0.05, 0.001, 1.0, "m", "radius of a wheel"),
            track: number("track_m", 0.3, 0.01, 5.0, "m", "between the two wheels"),
            max_speed: number(
                "max_speed",
                0.6,
                0.0,
                10.0,
                "m/s",
                "never faster, forward or backward",
            ),
            max_turn: number("max_turn", 1.5, 0.0, 20.0, "rad/s", "never turns faster"),
            max_acceleration: number(
                "max_acceleration",
                1.0,
                0.01,
                50.0,
                "m/s²",
                "never speeds up or brakes harder",
            ),
            max_turn_acceleration: number(
                "max_turn_acceleration",
                3.0,
                0.01,
                100.0,
                "rad/s²",
                "never changes its turn faster",
            ),
            max_wheel_speed: number(
                "max_wheel_speed",
                20.0,
                0.0,
                1000.0,
                "rad/s",
                "what the motors can do",
            ),
            command_timeout: number(
                "command_timeout_s",
                0.15,
                0.0,
                10.0,
                "s",
                "after so long without a new twist the wheels stop at once",
            ),
            start: interface
                .setting(
                    "start",
                    [0.0; 3],
                    "where the robot stands at the beginning: x m, y m, yaw rad",
                )
                .declare(),
            frame: interface.property(
                "frame",
                "map".to_owned(),
                "the frame of the start pose and of the odometry",
            ),
            base_frame: interface.property(
                "base_frame",
                "base_link".to_owned(),
                "the frame of the robot's body",
            ),
        }
    }

    fn geometry(&self, cycle: &Cycle<'_>) -> Drive {
        Drive {
            wheel_radius: cycle.property(self.wheel_radius),
            track: cycle.property(self.track),
        }
    }

    fn limits(&self, cycle: &Cycle<'_>) -> Limits {
        Limits {
            speed: cycle.property(self.max_speed),
            turn: cycle.property(self.max_turn),
            acceleration: cycle.property(self.max_acceleration),
            turn_acceleration: cycle.property(self.max_turn_acceleration),
            wheel_speed: cycle.property(self.max_wheel_speed),
        }
    }
}
