//! The current order, to follow a path or to stop, and the events about it.

use asmotion_component::Properties;
use asmotion_geometry::{NearestOnLine, Point, Polyline, Pose, message, turn, yaw};
use asmotion_messages::{Path, Time, Twist};
use serde::{Deserialize, Serialize};

use crate::caution::{CautiousView, PlaceOnPath};
use crate::motion::MeasuredMotion;
use crate::pursuit::Pursuit;

/// Tolerances within which the goal counts as reached, and the robot as standing.
#[derive(Debug, Clone, Copy, PartialEq, Properties)]
pub struct Tolerance {
    /// Distance from the last pose of the path within which the goal is reached.
    #[property(unit = "m", range = 0.005..=10.0, default = 0.05)]
    pub goal_tolerance_m: f64,
    /// Deviation from the heading of the last pose within which the goal is reached.
    #[property(unit = "rad", range = 0.01..=3.2, default = 0.1)]
    pub heading_tolerance: f64,
    /// Forward speed up to which the robot counts as standing.
    #[property(unit = "m/s", range = 1e-6..=1.0, default = 0.01)]
    pub standing_speed: f64,
    /// Turn rate up to which the robot counts as standing.
    #[property(unit = "rad/s", range = 1e-6..=1.0, default = 0.02)]
    pub standing_turn: f64,
    /// Whether the robot turns to the heading of the last pose; `heading_tolerance` counts only then.
    #[property(default = true)]
    pub goal_heading: bool,
}

/// Result of a cycle.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct FollowStep {
    /// Velocity to drive.
    pub twist: Twist,
    /// The event to publish, if any.
    pub event: Option<FollowerEvent>,
    /// `true` if there is no point of the path near the robot, so that it cannot be followed.
    pub lost: bool,
}

impl FollowStep {
    fn drive(twist: Twist) -> Self {
        Self {
            twist,
            event: None,
            lost: false,
        }
    }

    fn stand(event: Option<FollowerEvent>) -> Self {
        Self {
            event,
            ..Self::drive(Twist::default())
        }
    }
}

/// Result of a step along a path.
enum PathStep {
    Drive(Twist),
    /// The robot is at the goal.
    There,
    /// No point of the path is near the robot.
    Lost,
}

/// Event published once for each order.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum FollowerEvent {
    /// The robot stands at the end of the path.
    Reached,
    /// The robot stands after an order to stop.
    Halted,
}

/// The current order.
#[derive(Debug, Clone, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum FollowTask {
    /// No order yet, or the last one is done and reported.
    #[default]
    Idle,
    /// Stopping, on the order with this stamp; reported when the robot stands.
    Stop(Time),
    /// Following a path.
    Follow(FollowedPath),
    /// At the end of a path. The identity is kept to recognise amendments of the path.
    Arrived(PathIdentity),
}

/// Identity of an order: stamp and last pose of its path. An adapter that bends a path keeps both.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct PathIdentity {
    stamp: Time,
    goal: asmotion_messages::Pose,
}

/// A path being followed.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct FollowedPath {
    identity: PathIdentity,
    line: Polyline,
    goal: Pose,
    /// Position along the line, m. The robot is searched for only near it, so that it does not jump to another lap.
    progress: Option<f64>,
    rotating: bool,
    /// The goal's position has been reached within the tolerance; only the heading is left.
    there: bool,
}

/// Range along the line in which the robot is searched for, in m before and after its last position. An amendment may
/// change the length of the path up to the robot by as much.
const SEARCH: (f64, f64) = (1.0, 1.5);

/// Length in m from which a path is not usable: its numbers are no positions.
const LONGEST: f64 = 1e6;

/// Largest length of path before its end at which the robot can be at the goal, in goal tolerances.
const LAST: f64 = 4.0;

impl FollowTask {
    /// Accepts an order. A path without poses is an order to stop; an amendment of the current path is followed from
    /// the current position; a path that was reached is not driven again.
    pub fn order(&mut self, path: &Path) {
        let Some(last) = path.poses.last() else {
            *self = Self::Stop(path.header.stamp);
            return;
        };
        let poses = path.poses.iter();
        let line = Polyline::new(poses.map(|stamped| message::point(&stamped.pose.position)));
        let goal = message::pose(&last.pose);
        let is_finite = goal.to_homogeneous().iter().all(|it| it.is_finite());
        if line.is_empty() || !is_finite || line.length() > LONGEST {
            *self = Self::Stop(path.header.stamp); // a path without a usable pose is an order to stop
            return;
        }
        let identity = PathIdentity {
            stamp: path.header.stamp,
            goal: last.pose,
        };
        match self {
            Self::Arrived(reached) if *reached == identity => {}
            Self::Follow(route) if route.identity == identity => {
                route.line = line;
            }
            Self::Idle | Self::Stop(_) | Self::Follow(_) | Self::Arrived(_) => {
                *self = Self::Follow(FollowedPath {
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

    /// Computes the velocity for this cycle. Without a view, obstacles do not limit the speed.
    pub fn step(
        &mut self,
        pursuit: &Pursuit,
        tolerance: &Tolerance,
        motion: &MeasuredMotion,
        view: Option<&CautiousView<'_>>,
    ) -> FollowStep {
        let stands = motion.speed.abs() <= tolerance.standing_speed
            && motion.turn.abs() <= tolerance.standing_turn;
        match self {
            Self::Idle | Self::Arrived(_) => FollowStep::stand(None),
            Self::Stop(_) if stands => {
                *self = Self::Idle;
                FollowStep::stand(Some(FollowerEvent::Halted))
            }
            Self::Stop(_) => FollowStep::stand(None),
            Self::Follow(route) => match route.step(pursuit, tolerance, motion, view) {
                PathStep::Drive(twist) => FollowStep::drive(twist),
                PathStep::There if stands => {
                    *self = Self::Arrived(route.identity);
                    FollowStep::stand(Some(FollowerEvent::Reached))
                }
                PathStep::There => FollowStep::stand(None),
                PathStep::Lost => FollowStep {
                    lost: true,
                    ..FollowStep::stand(None)
                },
            },
        }
    }

    /// The stamp of the order; zero without one.
    pub fn stamp(&self) -> Time {
        match self {
            Self::Idle => Time::default(),
            Self::Stop(stamp) => *stamp,
            Self::Follow(route) => route.identity.stamp,
            Self::Arrived(identity) => identity.stamp,
        }
    }

    /// Returns whether the order is a path.
    pub fn is_following(&self) -> bool {
        match self {
            Self::Follow(_) => true,
            Self::Idle | Self::Stop(_) | Self::Arrived(_) => false,
        }
    }

    /// Returns whether there is an order that is not done yet.
    pub fn is_busy(&self) -> bool {
        match self {
            Self::Stop(_) | Self::Follow(_) => true,
            Self::Idle | Self::Arrived(_) => false,
        }
    }
}

impl FollowedPath {
    fn step(
        &mut self,
        pursuit: &Pursuit,
        tolerance: &Tolerance,
        motion: &MeasuredMotion,
        view: Option<&CautiousView<'_>>,
    ) -> PathStep {
        let here = Point::from(motion.pose.translation.vector);
        let Some(along) = self.nearest(here).map(|nearest| nearest.along) else {
            return PathStep::Lost;
        };
        self.progress = Some(along);
        let from_goal = (Point::from(self.goal.translation.vector) - here).norm();
        // once at the goal, a small drift while turning does not make the robot drive again
        let tolerance_m = if self.there { 2.0 } else { 1.0 } * tolerance.goal_tolerance_m;
        // a path that passes its goal, or begins at it, is driven to its end
        let remaining = self.line.length() - along;
        self.there = from_goal <= tolerance_m && remaining <= LAST * tolerance_m;
        if self.there {
            return self
                .align(pursuit, tolerance, motion)
                .map_or(PathStep::There, PathStep::Drive);
        }
        let Some(carrot) = pursuit.carrot(&self.line, here, along, motion.speed) else {
            return PathStep::Lost;
        };
        let carrot = motion.pose.inverse() * carrot;
        let twist = pursuit.drive(carrot.coords, remaining.max(from_goal), &mut self.rotating);
        let place = PlaceOnPath {
            line: &self.line,
            along,
            carrot,
        };
        PathStep::Drive(match view {
            Some(view) => view.limit(pursuit, &place, motion, twist),
            None => twist,
        })
    }

    /// The position of the robot on the path: near its last one; at the beginning, the first point from the start on
    /// that is nearer than its neighbours, or any if the robot is not near the path there.
    fn nearest(&self, here: Point) -> Option<NearestOnLine> {
        if let Some(progress) = self.progress {
            return self
                .line
                .nearest_between(here, progress - SEARCH.0, progress + SEARCH.1);
        }
        let mut start = self.line.nearest_between(here, 0.0, SEARCH.1)?;
        loop {
            let on = self
                .line
                .nearest_between(here, start.along, start.along + SEARCH.1)?;
            if on.distance >= start.distance {
                break;
            }
            start = on;
        }
        if start.distance <= SEARCH.0 {
            return Some(start);
        }
        self.line.nearest(here)
    }

    /// The turn to the goal's heading; `None` once it is within the tolerance or not requested.
    fn align(
        &self,
        pursuit: &Pursuit,
        tolerance: &Tolerance,
        motion: &MeasuredMotion,
    ) -> Option<Twist> {
        let wrong = turn(yaw(&motion.pose), yaw(&self.goal));
        let matters = tolerance.goal_heading && wrong.abs() > tolerance.heading_tolerance;
        matters.then(|| pursuit.rotate(wrong))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pursuit::tests::PURSUIT;
    use asmotion_geometry::heading;

    const TOLERANCE: Tolerance = Tolerance {
        goal_tolerance_m: 0.05,
        heading_tolerance: 0.1,
        standing_speed: 0.01,
        standing_turn: 0.02,
        goal_heading: true,
    };

    fn path(nanos: i64, goal_yaw: f64) -> Path {
        Path::from_poses(
            nanos,
            "map",
            [
                asmotion_messages::Pose::planar(0.0, 0.0, 0.0),
                asmotion_messages::Pose::planar(2.0, 0.0, goal_yaw),
            ],
        )
    }

    fn motion(x: f64, yaw: f64, speed: f64) -> MeasuredMotion {
        MeasuredMotion {
            pose: heading(Point::new(x, 0.0), yaw),
            speed,
            turn: 0.0,
        }
    }

    fn step(task: &mut FollowTask, motion: MeasuredMotion) -> (f64, f64, Option<FollowerEvent>) {
        let FollowStep { twist, event, .. } = task.step(&PURSUIT, &TOLERANCE, &motion, None);
        (twist.linear.x, twist.angular.z, event)
    }

    #[test]
    fn it_is_there_once_it_stands_within_the_tolerance() {
        let mut task = FollowTask::default();
        task.order(&path(1, 0.0));
        assert!(step(&mut task, motion(1.0, 0.0, 0.5)).0 > 0.4);
        assert_eq!(
            step(&mut task, motion(1.97, 0.0, 0.1)),
            (0.0, 0.0, None),
            "it still rolls"
        );
        assert_eq!(
            step(&mut task, motion(1.98, 0.0, 0.0)),
            (0.0, 0.0, Some(FollowerEvent::Reached))
        );
        assert_eq!(
            step(&mut task, motion(1.98, 0.0, 0.0)),
            (0.0, 0.0, None),
            "it says so once"
        );
        assert!(!task.is_busy());
    }

    #[test]
    fn it_turns_to_the_heading_of_the_last_pose() {
        let mut task = FollowTask::default();
        task.order(&path(1, 1.0));
        let (speed, turn, news) = step(&mut task, motion(2.0, 0.0, 0.0));
        assert!(speed == 0.0 && turn > 0.5 && news.is_none());
        assert_eq!(
            step(&mut task, motion(2.0, 0.95, 0.0)).2,
            Some(FollowerEvent::Reached)
        );
        let mut careless = FollowTask::default();
        careless.order(&path(1, 1.0));
        let whatever = Tolerance {
            goal_heading: false,
            ..TOLERANCE
        };
        assert_eq!(
            careless
                .step(&PURSUIT, &whatever, &motion(2.0, 0.0, 0.0), None)
                .event,
            Some(FollowerEvent::Reached)
        );
    }

    #[test]
    fn it_says_halted_once_for_every_stop_even_when_it_stands_already() {
        let mut task = FollowTask::default();
        for _ in 0..2 {
            task.order(&Path::default());
            assert_eq!(step(&mut task, motion(0.0, 0.0, 0.3)), (0.0, 0.0, None));
            assert_eq!(
                step(&mut task, motion(0.1, 0.0, 0.0)),
                (0.0, 0.0, Some(FollowerEvent::Halted))
            );
            assert_eq!(step(&mut task, motion(0.1, 0.0, 0.0)), (0.0, 0.0, None));
        }
    }

    #[test]
    fn a_bent_path_is_the_same_order_and_a_new_one_is_not() {
        let mut task = FollowTask::default();
        task.order(&path(1, 0.0));
        step(&mut task, motion(1.9, 0.0, 0.0));
        let mut bent = path(1, 0.0);
        bent.poses.insert(
            1,
            asmotion_messages::PoseStamped {
                pose: asmotion_messages::Pose::planar(1.0, 0.3, 0.0),
                ..Default::default()
            },
        );
        task.order(&bent);
        assert_eq!(
            step(&mut task, motion(2.0, 0.0, 0.0)).2,
            Some(FollowerEvent::Reached)
        );
        task.order(&bent);
        assert_eq!(
            step(&mut task, motion(2.0, 0.0, 0.0)).2,
            None,
            "it was reached already"
        );
        task.order(&path(2, 0.0));
        assert_eq!(
            step(&mut task, motion(2.0, 0.0, 0.0)).2,
            Some(FollowerEvent::Reached)
        );
        // after a stop, the same path is driven again
        task.order(&Path::default());
        step(&mut task, motion(2.0, 0.0, 0.0));
        task.order(&path(2, 0.0));
        assert_eq!(
            step(&mut task, motion(2.0, 0.0, 0.0)).2,
            Some(FollowerEvent::Reached)
        );
    }

    #[test]
    fn it_does_not_jump_to_another_lap() {
        // out and back with an offset of 0.1 m: for a while the way back is nearer than the way out
        let points = [(0.0, 0.0), (4.0, 0.0), (4.0, 0.1), (0.0, 0.1)];
        let poses = points.map(|(x, y)| asmotion_messages::Pose::planar(x, y, 0.0));
        let mut task = FollowTask::default();
        task.order(&Path::from_poses(1, "map", poses));
        let mut drifting = motion(0.5, 0.0, 0.5);
        for step_on in 0..20 {
            drifting.pose = heading(Point::new(0.5 + 0.1 * f64::from(step_on), 0.08), 0.0);
            let (speed, _, _) = step(&mut task, drifting);
            assert!(speed > 0.0, "it goes on and does not turn round");
        }
    }

    #[test]
    fn a_closed_path_is_driven_to_its_end() {
        // a figure of eight that ends where it begins, and passes that place halfway
        let at = |part: f64| {
            let angle = std::f64::consts::TAU * part;
            let (x, y) = (2.0 * angle.sin(), (2.0 * angle).sin());
            let yaw = (2.0 * (2.0 * angle).cos()).atan2(2.0 * angle.cos());
            asmotion_messages::Pose::planar(x, y, yaw)
        };
        let path = Path::from_poses(1, "map", (0..=200).map(|n| at(f64::from(n) / 200.0)));
        let points = path
            .poses
            .iter()
            .map(|it| message::point(&it.pose.position));
        let length = Polyline::new(points).length();
        // also if it is ordered again and again: the robot goes on where it is
        for is_repeated in [false, true] {
            let mut task = FollowTask::default();
            task.order(&path);
            let mut here = MeasuredMotion {
                pose: message::pose(&path.poses[0].pose),
                speed: 0.0,
                turn: 0.0,
            };
            let (mut driven, mut reached_after) = (0.0, Vec::new());
            for _ in 0..2000 {
                if is_repeated {
                    task.order(&path);
                }
                let (speed, turn, event) = step(&mut task, here);
                (here.speed, here.turn) = (speed, turn);
                here.pose = asmotion_geometry::roll(&here.pose, speed * 0.05, turn * 0.05);
                driven += speed * 0.05;
                reached_after.extend(event.map(|event| (event, driven)));
            }
            let [(FollowerEvent::Reached, driven)] = reached_after[..] else {
                panic!("{reached_after:?}");
            };
            assert!(
                (driven / length - 1.0).abs() < 0.05,
                "{driven} of {length} m"
            );
        }
    }

    #[test]
    fn a_path_to_nowhere_is_a_stop() {
        for goal in [f64::NAN, f64::INFINITY, 1e308, -1e7] {
            let mut task = FollowTask::default();
            let poses = [0.0, goal].map(|x| asmotion_messages::Pose::planar(x, 0.0, 0.0));
            task.order(&Path::from_poses(1, "map", poses));
            assert_eq!(
                step(&mut task, motion(0.0, 0.0, 0.0)).2,
                Some(FollowerEvent::Halted)
            );
        }
    }
}
