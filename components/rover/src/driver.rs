//! The component: reads twist and encoders, writes wheel speeds and odometry.

use std::time::Duration;

use asmotion_component::{
    Component, Cycle, Fault, Flow, Freeze, In, Interface, Out, Ports, Properties, PropertySet,
    Setup, Time, freeze_by_fields,
};
use asmotion_geometry::{Point, Pose, heading, message};
use asmotion_messages::{Encoders, Event, Header, Odometry, Twist, WheelSpeeds};

use crate::drive::{DifferentialDrive, DriveLimits, Velocity};
use crate::odometry::Odometer;
use crate::stall::{Contact, StallLimits, WheelWatch};

/// `nav::sim::RoverDriver`: drives the wheels by the newest twist; stops them once it is too old, or when they stall.
#[derive(Freeze)]
#[freeze(component = "nav::sim::RoverDriver", version = 1)]
pub struct RoverDriver {
    #[freeze(skip)]
    ports: RoverPorts,
    properties: PropertySet<RoverProperties>,

    odometer: Odometer,
    /// Velocity of the last command to the wheels.
    velocity: Velocity,
    /// Velocity of the newest twist, and the cycle that received it.
    target: Option<(Velocity, Time)>,
    /// Time of the last cycle.
    last: Option<Time>,
    left: WheelWatch,
    right: WheelWatch,
    /// The contact that holds the robot.
    contact: Option<Contact>,
}

#[derive(Ports)]
struct RoverPorts {
    /// Velocity to drive, `linear.x` in m/s and `angular.z` in rad/s, base frame.
    #[port(command)]
    twist: In<Twist>,
    /// Angles by which the wheels have turned, rad, cumulative.
    encoders: In<Encoders>,
    /// Wheel speeds to drive, rad/s, every cycle.
    #[port(safe)]
    wheels: Out<WheelSpeeds>,
    /// Pose by dead reckoning, for every reading of the encoders and with its stamp; in `frame`.
    odom: Out<Odometry>,
    /// `CONTACT` when wheels are commanded to turn and do not. The wheels stop at once, and twists in the same direction are
    /// refused until another one arrives, for example zero.
    event: Out<Event>,
}

#[derive(Properties)]
struct RoverProperties {
    #[property(flatten)]
    drive: DifferentialDrive,
    #[property(flatten)]
    limits: DriveLimits,
    #[property(flatten)]
    stall: StallLimits,
    /// Time without a new twist after which the wheels stop at once, without a ramp.
    #[property(range = "0s"..="10s", default = "150ms")]
    command_timeout_s: Duration,
    /// Pose at the start: x m, y m, yaw rad. Must equal the world's. Read when configured.
    start: [f64; 3],
    /// Frame of the start pose and of the odometry.
    #[property(default = "map")]
    frame: String,
    /// Frame of the robot's body.
    #[property(default = "base_link")]
    base_frame: String,
}

impl RoverDriver {
    /// Declares ports and properties.
    pub fn new(interface: &mut Interface) -> Self {
        Self {
            ports: interface.ports(),
            properties: interface.properties(),
            odometer: Odometer::new(Pose::identity()),
            velocity: Velocity::default(),
            target: None,
            last: None,
            left: WheelWatch::default(),
            right: WheelWatch::default(),
            contact: None,
        }
    }

    /// Computes the wheel speeds for the next cycle. If the newest command is too old, the wheels stop at once, without
    /// a ramp.
    fn drive(&mut self, cycle: &mut Cycle<'_>) {
        let now = cycle.now();
        let RoverProperties { drive, limits, .. } = &*self.properties;
        if let Flow::NewData(twist) = cycle.read(self.ports.twist) {
            let target = Velocity {
                speed: twist.linear.x,
                turn: twist.angular.z,
            };
            let standing = self.properties.stall.stall_speed;
            self.contact = self.contact.filter(|it| it.holds(target, standing));
            self.target = Some((target, now));
        }
        let dt = self
            .last
            .map_or(0.0, |last| (now.nanos() - last.nanos()) as f64 * 1e-9);
        self.last = Some(now);
        let timeout = self.properties.command_timeout_s;
        let stale = cycle.is_stale(self.ports.twist);
        self.velocity = match self.target {
            Some((wanted, at)) if now.since(at) < timeout && !stale => match self.contact {
                Some(_) => Velocity::default(),
                None => limits.toward(drive, self.velocity, wanted, dt),
            },
            _ => {
                self.target = None;
                Velocity::default()
            }
        };
        cycle.write(self.ports.wheels, drive.wheels(self.velocity));
    }

    /// Integrates the newest reading of the encoders and publishes the pose.
    fn locate(&mut self, cycle: &mut Cycle<'_>) {
        let Flow::NewData(encoders) = cycle.read(self.ports.encoders) else {
            return;
        };
        self.odometer.update(&self.properties.drive, encoders);
        let stalled = self.stalled(cycle.now());
        let mut odometry = Odometry {
            header: Header {
                stamp: encoders.stamp,
                frame_id: self.properties.frame.clone(),
            },
            child_frame_id: self.properties.base_frame.clone(),
            ..Odometry::default()
        };
        let velocity = self.odometer.velocity();
        odometry.pose.pose = message::pose_message(self.odometer.pose());
        odometry.twist.twist = Twist::planar(velocity.speed, velocity.turn);
        cycle.write(self.ports.odom, odometry);
        if let Some(wheels) = stalled
            && self.contact.is_none()
        {
            self.contact = Some(Contact::new(self.velocity));
            let place = self.odometer.pose().translation;
            let detail = format!("{wheels} at ({:.2}, {:.2}) by odometry", place.x, place.y);
            let event = Event::new(cycle.now().nanos(), Event::CONTACT, detail);
            cycle.write(self.ports.event, event);
        }
    }

    /// Compares the newest reading of the encoders with the last command. Returns what is stalled.
    fn stalled(&mut self, now: Time) -> Option<&'static str> {
        let RoverProperties { drive, stall, .. } = &*self.properties;
        let commanded = drive.wheels(self.velocity);
        let measured = drive.wheels(self.odometer.velocity());
        let radius = drive.wheel_radius_m;
        let watch = |wheel: &mut WheelWatch, commanded: f64, measured: f64| {
            wheel.update(now, commanded * radius, measured * radius, stall)
        };
        let left = watch(&mut self.left, commanded.left, measured.left);
        let right = watch(&mut self.right, commanded.right, measured.right);
        match (left, right) {
            (true, true) => Some("both wheels stall"),
            (true, false) => Some("the left wheel stalls"),
            (false, true) => Some("the right wheel stalls"),
            (false, false) => None,
        }
    }
}

impl Component for RoverDriver {
    freeze_by_fields!();

    fn configure(&mut self, setup: &mut Setup<'_>) -> Result<(), Fault> {
        let [x, y, yaw] = self.properties.refresh(setup).start;
        self.odometer = Odometer::new(heading(Point::new(x, y), yaw));
        Ok(())
    }

    fn start(&mut self) -> Result<(), Fault> {
        self.velocity = Velocity::default();
        self.target = None;
        self.last = None;
        self.left = WheelWatch::default();
        self.right = WheelWatch::default();
        self.contact = None;
        Ok(())
    }

    fn update(&mut self, cycle: &mut Cycle<'_>) -> Result<(), Fault> {
        self.properties.refresh(cycle);
        self.locate(cycle);
        self.drive(cycle);
        Ok(())
    }
}
