//! The component: reads a command, the raw scan and odometry; writes what may be driven of the command.

use std::time::Duration;

use asmotion_component::{
    Component, Cycle, Fault, Flow, Freeze, In, Interface, NOTICE_REPORT, Out, Ports, Properties,
    PropertySet, Time, freeze_by_fields,
};
use asmotion_geometry::{Point, Pose, heading, roll};
use asmotion_messages::{Event, LaserScan, Odometry, Twist};
use serde::{Deserialize, Serialize};

use crate::zones::{PlanarVelocity, Verdict, Zones};

/// `nav::CollisionMonitor`: passes a command on as far as the robot can stop before everything the laser sees; without a
/// scan it stops the robot.
#[derive(Freeze)]
#[freeze(component = "nav::CollisionMonitor", version = 1)]
pub struct CollisionMonitor {
    #[freeze(skip)]
    ports: MonitorPorts,
    properties: PropertySet<MonitorProperties>,

    /// The newest command, and the cycle that received it.
    command: Option<(PlanarVelocity, Time)>,
    /// The velocity last written.
    written: PlanarVelocity,
    /// Velocity of the robot, and the cycle that received it.
    robot: Option<(PlanarVelocity, Time)>,
    /// Points of the newest usable scan, moved along with the robot; base frame.
    points: Vec<Point>,
    /// The cycle that received the newest usable scan.
    seen: Option<Time>,
    /// Time of the last cycle.
    last: Option<Time>,
    /// The reason for which the robot is stopped; reported when it changes.
    stopped: Option<StopReason>,
    /// `true` if the newest usable scan ends within the robot.
    touched: bool,
}

/// Reason to stop the robot.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
enum StopReason {
    NoScan,
    StaleScan,
    StaleOdometry,
    Obstacle,
}

impl StopReason {
    /// Returns the text for the report.
    fn words(self) -> &'static str {
        match self {
            Self::NoScan => "stops the robot: no scan",
            Self::StaleScan => "stops the robot: stale scan",
            Self::StaleOdometry => "stops the robot: stale odometry",
            Self::Obstacle => "stops the robot: an obstacle is within the stopping distance",
        }
    }
}

#[derive(Ports)]
struct MonitorPorts {
    /// Requested velocity, `linear.x` in m/s and `angular.z` in rad/s, base frame.
    #[port(command)]
    command: In<Twist>,
    /// Scan of the laser at `mount`. A scan in which more than half of the beams failed does not count.
    scan: In<LaserScan>,
    /// Optional: velocity of the robot. Without it the robot counts as driving at the last velocity passed on.
    odom: In<Odometry>,
    /// Part of the command that may be driven, once for each command; in between only if a new scan requires less.
    #[port(safe)]
    twist: Out<Twist>,
    /// `CONTACT` when a scan ends within the robot's disc, once until a scan does not.
    event: Out<Event>,
}

#[derive(Properties)]
struct MonitorProperties {
    #[property(flatten)]
    zones: Zones,
    /// Age of the newest scan beyond which the robot is stopped.
    #[property(range = "0s"..="60s", default = "300ms")]
    scan_timeout_s: Duration,
    /// Age of the newest odometry beyond which the robot is stopped, once there has been one.
    #[property(range = "0s"..="10s", default = "200ms")]
    odom_timeout_s: Duration,
    /// Age of the newest command beyond which it is not corrected any more.
    #[property(range = "0s"..="10s", default = "150ms")]
    command_timeout_s: Duration,
    /// Pose of the laser on the robot: x m, y m, yaw rad, base frame. Must equal the laser driver's.
    mount: [f64; 3],
}

impl CollisionMonitor {
    /// Declares ports and properties.
    pub fn new(interface: &mut Interface) -> Self {
        Self {
            ports: interface.ports(),
            properties: interface.properties(),
            command: None,
            written: PlanarVelocity::default(),
            robot: None,
            points: Vec::new(),
            seen: None,
            last: None,
            stopped: None,
            touched: false,
        }
    }

    /// Velocity of the robot, measured or, without odometry, as commanded.
    fn velocity(&self) -> PlanarVelocity {
        self.robot.map_or(self.written, |(robot, _)| robot)
    }

    /// Moves the points with the robot and takes those of a new scan. Returns whether there was one.
    fn look(&mut self, cycle: &Cycle<'_>) -> bool {
        let now = cycle.now();
        if let Some(last) = self.last.replace(now) {
            let dt = (now.nanos() - last.nanos()) as f64 * 1e-9;
            let PlanarVelocity { speed, turn } = self.velocity();
            let moved = roll(&Pose::identity(), speed * dt, turn * dt).inverse();
            self.points
                .iter_mut()
                .for_each(|point| *point = moved * *point);
        }
        if let Flow::NewData(odometry) = cycle.read(self.ports.odom) {
            let velocity = planar(&odometry.twist.twist);
            self.robot = velocity
                .is_finite()
                .then_some((velocity, now))
                .or(self.robot);
        }
        let Flow::NewData(scan) = cycle.read(self.ports.scan) else {
            return false;
        };
        if !scan.sees() {
            return false;
        }
        let [x, y, yaw] = self.properties.mount;
        let laser = heading(Point::new(x, y), yaw);
        let point =
            |(angle, range): (f64, f64)| Point::new(range * angle.cos(), range * angle.sin());
        self.points.clear();
        self.points
            .extend(scan.obstacles().map(|beam| laser * point(beam)));
        self.seen = Some(now);
        true
    }

    /// Publishes `CONTACT` if the newest scan is the first that ends within the robot.
    fn feel(&mut self, cycle: &mut Cycle<'_>) {
        let touched = self.properties.zones.is_touched(&self.points);
        if touched && !self.touched {
            let detail = "the scan ends within the robot";
            let event = Event::new(cycle.now().nanos(), Event::CONTACT, detail);
            cycle.write(self.ports.event, event);
        }
        self.touched = touched;
    }

    /// The reason that every motion is forbidden; `None` if the laser works.
    fn blindness(&self, now: Time) -> Option<StopReason> {
        let MonitorProperties {
            scan_timeout_s,
            odom_timeout_s,
            ..
        } = *self.properties;
        match (self.seen, self.robot) {
            (None, _) => Some(StopReason::NoScan),
            (Some(seen), _) if now.since(seen) > scan_timeout_s => Some(StopReason::StaleScan),
            (Some(_), Some((_, at))) if now.since(at) > odom_timeout_s => {
                Some(StopReason::StaleOdometry)
            }
            (Some(_), _) => None,
        }
    }

    /// Judges a command; returns the velocity to drive, and the reason if it is to stop.
    fn judge(&self, command: PlanarVelocity, now: Time) -> (PlanarVelocity, Option<StopReason>) {
        if let Some(reason) = self.blindness(now) {
            return (PlanarVelocity::default(), Some(reason));
        }
        let zones = &self.properties.zones;
        let verdict = zones.judge(command, self.velocity(), &self.points);
        let reason = match verdict {
            Verdict::Pass(_) | Verdict::Slow(_) => None,
            Verdict::Stop(_) => Some(StopReason::Obstacle),
        };
        (verdict.velocity(), reason)
    }
}

impl Component for CollisionMonitor {
    freeze_by_fields!();

    fn start(&mut self) -> Result<(), Fault> {
        self.command = None;
        self.written = PlanarVelocity::default();
        self.robot = None;
        self.points.clear();
        self.seen = None;
        self.last = None;
        self.stopped = None;
        self.touched = false;
        Ok(())
    }

    fn update(&mut self, cycle: &mut Cycle<'_>) -> Result<(), Fault> {
        let now = cycle.now();
        self.properties.refresh(cycle);
        let sees_anew = self.look(cycle);
        if sees_anew {
            self.feel(cycle);
        }
        let is_new = match cycle.read(self.ports.command) {
            Flow::NewData(twist) => {
                let command = Some(planar(twist)).filter(PlanarVelocity::is_finite);
                self.command = Some((command.unwrap_or_default(), now));
                true
            }
            Flow::OldData(_) | Flow::NoData => false,
        };
        let timeout = self.properties.command_timeout_s;
        let Some((command, at)) = self.command else {
            return Ok(());
        };
        if !(is_new || sees_anew && now.since(at) <= timeout) {
            return Ok(());
        }
        let (velocity, reason) = self.judge(command, now);
        // between two commands only a correction is written, so that the rover notices their end
        if is_new || velocity.speed.abs() < self.written.speed.abs() {
            self.written = velocity;
            cycle.write(
                self.ports.twist,
                Twist::planar(velocity.speed, velocity.turn),
            );
        }
        if reason != self.stopped {
            self.stopped = reason;
            let words = reason.map_or("lets the robot drive again", StopReason::words);
            cycle.report(NOTICE_REPORT, words.into());
        }
        Ok(())
    }
}

fn planar(twist: &Twist) -> PlanarVelocity {
    PlanarVelocity {
        speed: twist.linear.x,
        turn: twist.angular.z,
    }
}
