//! The component: reads path and odometry, writes twist and events.

use std::time::Duration;

use asmotion_component::{
    Component, Cycle, Fault, Flow, Freeze, In, Interface, NOTICE_REPORT, Out, Ports, Properties,
    PropertySet, Time, freeze_by_fields,
};
use asmotion_geometry::{Point, Trail, heading, message};
use asmotion_messages::{Bool, Event, LaserScan, Odometry, Path, Twist};
use serde::{Deserialize, Serialize};

use crate::caution::{Caution, CautiousView};
use crate::motion::MeasuredMotion;
use crate::pursuit::Pursuit;
use crate::task::{FollowStep, FollowTask, FollowerEvent, Tolerance};

/// `nav::TrajectoryFollower`: follows the newest path; publishes `REACHED` once at its end, `HALTED` once after a stop.
#[derive(Freeze)]
#[freeze(component = "nav::TrajectoryFollower", version = 2)]
pub struct TrajectoryFollower {
    #[freeze(skip)]
    ports: FollowerPorts,
    properties: PropertySet<FollowerProperties>,

    task: FollowTask,
    /// Frame of the newest path.
    frame: String,
    /// The cycle that received the newest odometry.
    located: Option<Time>,
    trail: Trail,
    /// Points of the newest usable scan, in the frame of the odometry.
    points: Vec<Point>,
    /// The cycle that received the newest usable scan; `None` for a follower without a laser.
    seen: Option<Time>,
    /// `true` once it was reported that there is no scan.
    unseeing: bool,
    /// The reason that the robot must not drive in spite of an order; reported when it changes.
    hindrance: Option<Hindrance>,
    /// `true` if the last cycle had an order, so that one final zero must be sent.
    commanding: bool,
}

/// Reason that prevents the robot from driving.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
enum Hindrance {
    NoOdometry,
    NoNumbers,
    NoPermission,
    StaleOdometry,
    FrameMismatch,
    StaleScan,
    Lost,
}

impl Hindrance {
    /// Returns the text for the report.
    fn description(self) -> &'static str {
        match self {
            Self::NoOdometry => "no odometry",
            Self::NoNumbers => "odometry without numbers",
            Self::NoPermission => "no permission to drive",
            Self::StaleOdometry => "stale odometry",
            Self::FrameMismatch => "odometry in another frame",
            Self::StaleScan => "stale scan",
            Self::Lost => "no point of the path is near",
        }
    }
}

#[derive(Ports)]
struct FollowerPorts {
    /// Path to follow. A path without poses is an order to stop.
    path: In<Path>,
    /// Pose and velocity of the robot, in the frame of the path.
    odom: In<Odometry>,
    /// Optional: permission to drive. While the newest is false no path is driven.
    permit: In<Bool>,
    /// Optional: scan of the laser at `mount`, which limits the speed so that the robot can stop before obstacles. Until the
    /// first one arrives obstacles do not limit it, which is reported.
    scan: In<LaserScan>,
    /// Velocity to drive, `linear.x` in m/s and `angular.z` in rad/s, base frame. Sent in every cycle while driving,
    /// then once as zero, then not at all.
    #[port(safe)]
    twist: Out<Twist>,
    /// `REACHED` once for each path, `HALTED` once for each stop, each when the robot stands; `plan` is the stamp of the path
    /// or stop.
    event: Out<Event>,
}

#[derive(Properties)]
struct FollowerProperties {
    #[property(flatten)]
    pursuit: Pursuit,
    #[property(flatten)]
    tolerance: Tolerance,
    #[property(flatten)]
    caution: Caution,
    /// Age of the newest odometry beyond which the robot does not drive.
    #[property(range = "0s"..="10s", default = "200ms")]
    odom_timeout_s: Duration,
    /// Age of the newest scan beyond which the robot does not drive, once there has been one.
    #[property(range = "0s"..="60s", default = "500ms")]
    scan_timeout_s: Duration,
    /// Pose of the laser on the robot: x m, y m, yaw rad, base frame. Must equal the laser driver's.
    mount: [f64; 3],
}

impl TrajectoryFollower {
    /// Declares ports and properties.
    pub fn new(interface: &mut Interface) -> Self {
        Self {
            ports: interface.ports(),
            properties: interface.properties(),
            task: FollowTask::default(),
            frame: String::new(),
            located: None,
            trail: Trail::default(),
            points: Vec::new(),
            seen: None,
            unseeing: false,
            hindrance: None,
            commanding: false,
        }
    }

    /// The reason that the robot must not drive in this cycle; `None` if it may.
    fn hindrance(&self, cycle: &Cycle<'_>, odometry: Option<&Odometry>) -> Option<Hindrance> {
        let (now, timeout) = (cycle.now(), self.properties.odom_timeout_s);
        let is_fresh = self.located.is_some_and(|at| now.since(at) <= timeout);
        let frame = |odometry: &Odometry| odometry.header.frame_id == self.frame;
        match odometry {
            None => Some(Hindrance::NoOdometry),
            Some(odometry) if !motion(odometry).is_finite() => Some(Hindrance::NoNumbers),
            Some(_) if !self.is_permitted(cycle) => Some(Hindrance::NoPermission),
            Some(_) if !is_fresh || cycle.is_stale(self.ports.odom) => {
                Some(Hindrance::StaleOdometry)
            }
            Some(odometry) if !self.frame.is_empty() && !frame(odometry) => {
                Some(Hindrance::FrameMismatch)
            }
            Some(_) if self.task.is_following() && !self.sees(now) => Some(Hindrance::StaleScan),
            Some(_) => None,
        }
    }
}

impl TrajectoryFollower {
    /// Returns whether the order is permitted: a path requires that `permit` is not false, a stop requires nothing.
    fn is_permitted(&self, cycle: &Cycle<'_>) -> bool {
        let permit = cycle.read(self.ports.permit).any();
        !self.task.is_following() || permit.is_none_or(|permit| permit.data)
    }

    /// Returns whether the newest scan is not too old; `true` without a laser.
    fn sees(&self, now: Time) -> bool {
        let timeout = self.properties.scan_timeout_s;
        self.seen.is_none_or(|at| now.since(at) <= timeout)
    }

    /// Places the points of a new scan where the robot was when it was taken.
    fn look(&mut self, cycle: &Cycle<'_>) {
        let Flow::NewData(scan) = cycle.read(self.ports.scan) else {
            return;
        };
        let robot = self.trail.at(scan.header.stamp.as_nanos());
        let Some(robot) = robot.filter(|_| scan.sees()) else {
            return;
        };
        let [x, y, yaw] = self.properties.mount;
        let laser = robot * heading(Point::new(x, y), yaw);
        let point =
            |(angle, range): (f64, f64)| Point::new(range * angle.cos(), range * angle.sin());
        self.points.clear();
        self.points
            .extend(scan.obstacles().map(|beam| laser * point(beam)));
        self.seen = Some(cycle.now());
    }

    /// Computes the velocity for a robot that may drive.
    fn follow(&mut self, motion: &MeasuredMotion) -> FollowStep {
        let FollowerProperties {
            pursuit,
            tolerance,
            caution,
            ..
        } = &*self.properties;
        let view = self.seen.is_some().then_some(CautiousView {
            caution,
            points: &self.points,
        });
        self.task.step(pursuit, tolerance, motion, view.as_ref())
    }

    /// Reports the reason that the robot must not drive when it changes.
    fn note(&mut self, cycle: &mut Cycle<'_>, hindrance: Option<Hindrance>) {
        if hindrance != self.hindrance {
            self.hindrance = hindrance;
            let words = hindrance.map_or("no more", Hindrance::description);
            cycle.report("hindered", words.into());
        }
    }

    /// Reports once that obstacles do not limit the speed, when the first path is driven.
    fn report_blindness(&mut self, cycle: &mut Cycle<'_>) {
        if self.seen.is_none() && !self.unseeing && self.task.is_following() {
            self.unseeing = true;
            let words = "without a scan, obstacles do not limit the speed";
            cycle.report(NOTICE_REPORT, words.into());
        }
    }
}

impl Component for TrajectoryFollower {
    freeze_by_fields!();

    fn start(&mut self) -> Result<(), Fault> {
        self.task = FollowTask::default();
        self.located = None;
        self.trail = Trail::default();
        self.points.clear();
        self.seen = None;
        self.unseeing = false;
        self.hindrance = None;
        self.commanding = false;
        Ok(())
    }

    fn update(&mut self, cycle: &mut Cycle<'_>) -> Result<(), Fault> {
        let now = cycle.now();
        self.properties.refresh(cycle);
        if let Flow::NewData(path) = cycle.read(self.ports.path) {
            self.task.order(path);
            self.frame.clone_from(&path.header.frame_id);
        }
        let odometry = match cycle.read(self.ports.odom) {
            Flow::NewData(odometry) => {
                self.located = Some(now);
                let pose = message::pose(&odometry.pose.pose);
                self.trail.add(odometry.header.stamp.as_nanos(), pose);
                Some(odometry)
            }
            Flow::OldData(odometry) => Some(odometry),
            Flow::NoData => None,
        };
        let odometry = odometry.cloned();
        self.look(cycle);
        self.report_blindness(cycle);
        let hindrance = self
            .hindrance(cycle, odometry.as_ref())
            .filter(|_| self.task.is_busy());
        let motion = odometry
            .as_ref()
            .filter(|_| hindrance.is_none())
            .map(motion);
        let (busy, plan) = (self.task.is_busy(), self.task.stamp());
        let FollowStep {
            twist,
            event: news,
            lost,
        } = motion.map_or_else(FollowStep::default, |motion| self.follow(&motion));
        self.note(cycle, hindrance.or(lost.then_some(Hindrance::Lost)));
        // a follower without a task is silent, so that others may drive; its last command is zero
        if busy || self.commanding {
            cycle.write(self.ports.twist, twist);
        }
        self.commanding = busy;
        if let (Some(news), Some(motion)) = (news, motion) {
            cycle.write(self.ports.event, event(now, news, &motion).about(plan));
        }
        Ok(())
    }
}

fn motion(odometry: &Odometry) -> MeasuredMotion {
    MeasuredMotion {
        pose: message::pose(&odometry.pose.pose),
        speed: odometry.twist.twist.linear.x,
        turn: odometry.twist.twist.angular.z,
    }
}

fn event(now: Time, event: FollowerEvent, motion: &MeasuredMotion) -> Event {
    let code = match event {
        FollowerEvent::Reached => Event::REACHED,
        FollowerEvent::Halted => Event::HALTED,
    };
    let place = motion.pose.translation;
    Event::new(
        now.nanos(),
        code,
        format!("at ({:.2}, {:.2}) by odometry", place.x, place.y),
    )
}
