//! The component: reads path and odometry, writes twist and events.

use std::time::Duration;

use asmotion_component::{
    Component, Cycle, Fault, Flow, Freeze, In, Interface, Out, Ports, Properties, PropertySet,
    Time, freeze_by_fields,
};
use asmotion_geometry::message;
use asmotion_messages::{Bool, Event, Odometry, Path, Twist};
use serde::{Deserialize, Serialize};

use crate::pursuit::Pursuit;
use crate::task::{FollowTask, FollowerEvent, MeasuredMotion, Tolerance};

/// `nav::TrajectoryFollower`: follows the newest path; publishes `REACHED` once at its end, `HALTED` once after a stop.
#[derive(Freeze)]
#[freeze(component = "nav::TrajectoryFollower", version = 1)]
pub struct TrajectoryFollower {
    #[freeze(skip)]
    ports: FollowerPorts,
    properties: PropertySet<FollowerProperties>,

    task: FollowTask,
    /// Frame of the newest path.
    frame: String,
    /// The cycle that received the newest odometry.
    located: Option<Time>,
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
    /// Velocity to drive, `linear.x` in m/s and `angular.z` in rad/s, base frame. Sent in every cycle while driving,
    /// then once as zero, then not at all.
    twist: Out<Twist>,
    /// `REACHED` once for each path, `HALTED` once for each stop, each when the robot stands.
    event: Out<Event>,
}

#[derive(Properties)]
struct FollowerProperties {
    #[property(flatten)]
    pursuit: Pursuit,
    #[property(flatten)]
    tolerance: Tolerance,
    /// Age of the newest odometry beyond which the robot does not drive.
    #[property(range = "0s"..="10s", default = "200ms")]
    odom_timeout_s: Duration,
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
}

impl Component for TrajectoryFollower {
    freeze_by_fields!();

    fn start(&mut self) -> Result<(), Fault> {
        self.task = FollowTask::default();
        self.located = None;
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
                Some(odometry)
            }
            Flow::OldData(odometry) => Some(odometry),
            Flow::NoData => None,
        };
        let hindrance = self
            .hindrance(cycle, odometry)
            .filter(|_| self.task.is_busy());
        let motion = odometry.filter(|_| hindrance.is_none()).map(motion);
        if hindrance != self.hindrance {
            self.hindrance = hindrance;
            let words = hindrance.map_or("no more", Hindrance::description);
            cycle.report("hindered", words.into());
        }
        let busy = self.task.is_busy();
        let (twist, news) = match &motion {
            Some(motion) => {
                let FollowerProperties {
                    pursuit, tolerance, ..
                } = &*self.properties;
                self.task.step(pursuit, tolerance, motion)
            }
            None => (Twist::default(), None),
        };
        // a follower without a task is silent, so that others may drive; its last command is zero
        if busy || self.commanding {
            cycle.write(self.ports.twist, twist);
        }
        self.commanding = busy;
        if let (Some(news), Some(motion)) = (news, motion) {
            cycle.write(self.ports.event, event(now, news, &motion));
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
        format!("at ({:.2}, {:.2})", place.x, place.y),
    )
}
