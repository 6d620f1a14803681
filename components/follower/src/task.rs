//! What the follower is doing: following a path to its end, or coming to a stand; and what it has to say about it.

use geometry::{Point, Polyline, Pose, message, turn, yaw};
use messages::{Path, Time, Twist};

use crate::pursuit::Settings;

/// When the robot is there.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Tolerance {
    /// m, from the last pose of the path.
    pub position: f64,
    /// rad, from the heading of the last pose; none if the heading does not matter.
    pub heading: Option<f64>,
    /// m/s, slower than this the robot stands.
    pub standing: f64,
    /// rad/s, slower than this it stands.
    pub standing_turn: f64,
}

/// Where the robot is and how it moves, as its odometry says.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Motion {
    /// In the frame of the path.
    pub pose: Pose,
    /// m/s forward.
    pub speed: f64,
    /// rad/s.
    pub turn: f64,
}

/// What is said once a task.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum News {
    /// The robot stands at the end of the path.
    Reached,
    /// The robot was told to stop and stands.
    Halted,
}

/// What the follower is doing.
#[derive(Debug, Clone, Default)]
pub enum Task {
    /// Nothing was ordered yet, or what was ordered is done and said.
    #[default]
    Idle,
    /// Coming to a stand, then saying so.
    Stop,
    /// On the way.
    Follow(Route),
    /// At the end of a path; kept, so that an amendment of it is known as such.
    Arrived(Identity),
}

/// What makes two paths the same order: when it was planned, and where it ends. An adapter that bends a path keeps both.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Identity {
    stamp: Time,
    goal: messages::Pose,
}

/// A path on the way.
#[derive(Debug, Clone)]
pub struct Route {
    identity: Identity,
    line: Polyline,
    goal: Pose,
    /// m along the line; never looks for the robot far from there, so that it does not jump to another lap.
    progress: Option<f64>,
    rotating: bool,
    /// Within the tolerance of the goal's position: only the heading is left.
    there: bool,
}

/// How far from its last place along the line the robot is looked for, m back and m ahead. An amended path may be
/// longer or shorter up to the robot by as much.
const SEARCH: (f64, f64) = (1.0, 1.5);

impl Task {
    /// Takes an order. A path without poses stops; the path that is being followed, with other bends, is gone on with;
    /// the path that was reached is not driven again.
    pub fn order(&mut self, path: &Path) {
        let Some(last) = path.poses.last() else {
            *self = Self::Stop;
            return;
        };
        let poses = path.poses.iter();
        let line = Polyline::new(poses.map(|stamped| message::point(&stamped.pose.position)));
        let goal = message::pose(&last.pose);
        if line.is_empty() || !goal.to_homogeneous().iter().all(|number| number.is_finite()) {
            *self = Self::Stop; // a path to nowhere is no path
            return;
        }
        let identity = Identity {
            stamp: path.header.stamp,
            goal: last.pose,
        };
        match self {
            Self::Arrived(reached) if *reached == identity => {}
            Self::Follow(route) if route.identity == identity => {
                route.line = line;
            }
            Self::Idle | Self::Stop | Self::Follow(_) | Self::Arrived(_) => {
                *self = Self::Follow(Route {
                    identity,
                    line,
                    goal,
                    progress: None,
                    rotating: false,
                    there: false,
                });
            }
        }
    }

    /// The command for now, and what there is to say.
    pub fn step(
        &mut self,
        settings: &Settings,
        tolerance: &Tolerance,
        motion: &Motion,
    ) -> (Twist, Option<News>) {
        let stands = motion.speed.abs() <= tolerance.standing
            && motion.turn.abs() <= tolerance.standing_turn;
        match self {
            Self::Idle | Self::Arrived(_) => (Twist::default(), None),
            Self::Stop if stands => {
                *self = Self::Idle;
                (Twist::default(), Some(News::Halted))
            }
            Self::Stop => (Twist::default(), None),
            Self::Follow(route) => match route.step(settings, tolerance, motion) {
                Some(twist) => (twist, None),
                None if stands => {
                    *self = Self::Arrived(route.identity);
                    (Twist::default(), Some(News::Reached))
                }
                None => (Twist::default(), None),
            },
        }
    }

    /// Whether there is something to drive or to say.
    pub fn is_busy(&self) -> bool {
        match self {
            Self::Stop | Self::Follow(_) => true,
            Self::Idle | Self::Arrived(_) => false,
        }
    }
}

impl Route {
    /// The command on the way; none once at the goal.
    fn step(&mut self, settings: &Settings, tolerance: &Tolerance, motion: &Motion) -> Option<Twist> {
        let here = Point::from(motion.pose.translation.vector);
        let from_goal = (Point::from(self.goal.translation.vector) - here).norm();
        // once there, a little drift while turning does not send the robot off again
        let near = if self.there { 2.0 } else { 1.0 } * tolerance.position;
        self.there = from_goal <= near;
        if self.there {
            return self.align(settings, tolerance, motion);
        }
        let (from, to) = match self.progress {
            Some(progress) => (progress - SEARCH.0, progress + SEARCH.1),
            None => (0.0, f64::INFINITY),
        };
        let along = self.line.nearest_between(here, from, to)?.along;
        self.progress = Some(along);
        let carrot = settings.carrot(&self.line, here, along, motion.speed)?;
        let carrot = motion.pose.inverse() * carrot;
        let remaining = (self.line.length() - along).max(from_goal);
        Some(settings.drive(carrot.coords, remaining, &mut self.rotating))
    }

    /// The turn to the goal's heading; none once it is right, or does not matter.
    fn align(&self, settings: &Settings, tolerance: &Tolerance, motion: &Motion) -> Option<Twist> {
        let wrong = turn(yaw(&motion.pose), yaw(&self.goal));
        let tolerated = tolerance.heading?;
        (wrong.abs() > tolerated).then(|| settings.rotate(wrong))
    }
}
