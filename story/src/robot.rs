//! The robots of a mission: their paths, goals and control states.

use std::collections::BTreeMap;

use asmotion_component::Time;
use asmotion_messages::Point;

use crate::common::common;
use crate::driven_path::{DrivenPath, distance};

/// The robots of a composite. A robot is a nested composite whose components publish odometry, or the whole composite.
///
/// Goals, true positions and control states belong to the robots that share the longest part of their component's name:
/// those of `Left/Coordinator` to `Left`, those of a coordinator outside to all robots.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Robots {
    paths: BTreeMap<String, DrivenPath>,
    goals: BTreeMap<String, Point>,
    true_positions: BTreeMap<String, Point>,
    /// By composite, then by component.
    control_states: BTreeMap<String, BTreeMap<String, String>>,
    /// By component, the inputs of the step that entered its control state.
    causes: BTreeMap<String, String>,
}

/// A robot at the end of a mission.
#[derive(Clone, Debug, PartialEq)]
pub struct RobotSummary<'a> {
    /// Name of its composite, as in `Left`; empty if it is the whole composite.
    pub name: &'a str,
    /// The driven path.
    pub path: &'a DrivenPath,
    /// The newest goal.
    pub goal: Option<Point>,
    /// The newest true position; `None` without a simulator.
    pub true_position: Option<Point>,
    /// The last control state of its coordinators; `None` if they differ, or if it has none.
    pub control_state: Option<&'a str>,
    /// The inputs of the step in which the only coordinator entered it, as in `event = NO_PATH`; empty without inputs.
    pub cause: &'a str,
}

impl RobotSummary<'_> {
    /// Distance to the newest goal by odometry, m; `None` without a goal.
    pub fn to_goal_m(&self) -> Option<f64> {
        Some(distance(&self.goal?, &self.path.at?))
    }

    /// True distance to the newest goal, m; `None` without a goal or a simulator.
    pub fn true_to_goal_m(&self) -> Option<f64> {
        Some(distance(&self.goal?, &self.true_position?))
    }
}

impl Robots {
    /// All robots by name, `Rover2` before `Rover10`.
    pub fn all(&self) -> impl Iterator<Item = RobotSummary<'_>> {
        let mut paths: Vec<_> = self.paths.iter().collect();
        paths.sort_by_key(|(name, _)| by_number(name));
        let all = paths.into_iter();
        all.map(|(name, path)| self.summary(name, path))
    }

    /// The only robot; `None` if there are several, or if nothing moved.
    pub fn only(&self) -> Option<RobotSummary<'_>> {
        let mut paths = self.paths.iter();
        let (name, path) = paths.next().filter(|_| paths.next().is_none())?;
        Some(self.summary(name, path))
    }

    fn summary<'a>(&'a self, name: &'a str, path: &'a DrivenPath) -> RobotSummary<'a> {
        let is_only = self.paths.len() == 1;
        let states = nearest(&self.control_states, name, is_only);
        let only = states.filter(|it| it.len() == 1);
        let coordinator = only.and_then(|it| it.keys().next());
        let cause = coordinator.and_then(|it| self.causes.get(it));
        RobotSummary {
            name,
            path,
            goal: nearest(&self.goals, name, is_only).copied(),
            true_position: nearest(&self.true_positions, name, is_only).copied(),
            control_state: states.and_then(|states| common(states.values())),
            cause: cause.map_or("", String::as_str),
        }
    }

    /// Handles a position of the robot to which the component belongs. Returns a report of progress, if due.
    pub(super) fn moved(&mut self, component: &str, at: Time, to: Point) -> Option<String> {
        let robot = composite_of(component);
        if !self.paths.contains_key(robot) {
            self.paths.insert(robot.to_owned(), DrivenPath::default());
        }
        let is_only = self.paths.len() == 1;
        let goal = || nearest(&self.goals, robot, is_only).copied();
        let report = self.paths.get_mut(robot)?.moved(at, to, goal)?;
        Some(if is_only {
            report
        } else {
            format!("{report} {robot}")
        })
    }

    /// Sets the goal of the robots that the component coordinates.
    pub(super) fn set_goal(&mut self, component: &str, goal: Point) {
        set(&mut self.goals, component, goal);
    }

    /// Sets the true position of the robots that the component simulates.
    pub(super) fn set_true_position(&mut self, component: &str, position: Point) {
        set(&mut self.true_positions, component, position);
    }

    /// Sets the control state of a coordinator.
    pub(super) fn set_control_state(&mut self, component: &str, state: &str) {
        let robot = composite_of(component).to_owned();
        let states = self.control_states.entry(robot).or_default();
        states.insert(component.to_owned(), state.to_owned());
    }

    /// Sets the inputs of the step in which a coordinator entered its control state.
    pub(super) fn set_cause(&mut self, component: &str, inputs: &[(String, String)]) {
        let told = inputs.iter().filter(|(_, value)| value != "false");
        let told = told.map(|(location, value)| format!("{location} = {value}"));
        let told: Vec<String> = told.collect();
        self.causes.insert(component.to_owned(), told.join(", "));
    }

    /// Forgets the control states of coordinators that are no longer present.
    pub(super) fn retain_control_states(&mut self, is_present: impl Fn(&str) -> bool) {
        for states in self.control_states.values_mut() {
            states.retain(|component, _| is_present(component));
        }
        self.control_states.retain(|_, states| !states.is_empty());
    }
}

/// Sorts names by the text before their last number, then by the number.
fn by_number(name: &str) -> (&str, u64, &str) {
    let text = name.trim_end_matches(|it: char| it.is_ascii_digit());
    let number = name.get(text.len()..).and_then(|it| it.parse().ok());
    (text, number.unwrap_or_default(), name)
}

/// The nested composite of a component: `Left` of `Left/RoverDriver`.
fn composite_of(component: &str) -> &str {
    component.rsplit_once('/').map_or("", |(outer, _)| outer)
}

/// Sets the point of a component's composite.
fn set(points: &mut BTreeMap<String, Point>, component: &str, to: Point) {
    let composite = composite_of(component);
    match points.get_mut(composite) {
        Some(point) => *point = to,
        None => {
            points.insert(composite.to_owned(), to);
        }
    }
}

/// The entry whose composite shares the most with the robot's; the first of several. Of several robots, each has only
/// entries that share something with it, or that are outside all nested composites.
fn nearest<'m, T>(
    by_composite: &'m BTreeMap<String, T>,
    robot: &str,
    is_only: bool,
) -> Option<&'m T> {
    let mut shared = Some(robot);
    while let Some(composite) = shared {
        let within = format!("{composite}/");
        let nested = || {
            let (name, value) = by_composite.range(within.clone()..).next()?;
            name.starts_with(&within).then_some(value)
        };
        let found = by_composite.get(composite).or_else(nested);
        if found.is_some() {
            return found;
        }
        shared = composite.rsplit_once('/').map(|(outer, _)| outer);
    }
    if is_only || robot.is_empty() {
        by_composite.values().next()
    } else {
        by_composite.get("")
    }
}

#[cfg(test)]
mod tests {
    use super::Robots;
    use asmotion_component::{Span, Time};
    use asmotion_messages::Point;

    fn at(x: f64) -> Point {
        Point {
            x,
            ..Point::default()
        }
    }

    #[test]
    fn each_robot_has_its_own_path_goal_and_state() {
        let mut robots = Robots::default();
        for tick in 0..=10_u32 {
            let now = Time::ZERO + (u64::from(tick) * 100).ms();
            let x = f64::from(tick);
            robots.moved("Left/Driver", now, at(x));
            robots.moved("Right/base/Driver", now, at(-2.0 * x));
            if tick == 5 {
                robots.set_goal("Left/Coordinator", at(11.0));
                robots.set_goal("Right/Coordinator", at(-25.0));
                robots.set_control_state("Left/Coordinator", "ARRIVED");
                robots.set_true_position("Left/World", at(9.0));
            }
        }
        let all: Vec<_> = robots.all().collect();
        assert_eq!((all[0].name, all[1].name), ("Left", "Right/base"));
        assert_eq!((all[0].path.driven_m, all[1].path.driven_m), (10.0, 20.0));
        assert_eq!(all[0].to_goal_m(), Some(1.0));
        assert_eq!(all[1].to_goal_m(), Some(5.0));
        assert_eq!(all[0].true_to_goal_m(), Some(2.0));
        assert_eq!(all[1].true_to_goal_m(), None);
        assert_eq!(all[0].control_state, Some("ARRIVED"));
        assert_eq!(all[1].control_state, None);
        assert_eq!(robots.only(), None);

        // a second coordinator of a robot
        robots.set_control_state("Left/Supervisor", "NORMAL");
        assert_eq!(robots.all().next().unwrap().control_state, None);
        robots.retain_control_states(|component| component != "Left/Coordinator");
        let state = robots.all().next().unwrap().control_state;
        assert_eq!(state, Some("NORMAL"));
    }

    /// `Left-2` is between `Left` and `Left/arm` in the order of texts.
    #[test]
    fn a_robot_has_what_shares_whole_names_with_it() {
        let mut robots = Robots::default();
        for (number, coordinator) in ["Left-2/C", "Left/arm/C", "Right/arm/C", "Right/base/C"]
            .into_iter()
            .enumerate()
        {
            robots.set_goal(coordinator, at(number as f64));
        }
        for driver in [
            "Left/Driver",
            "Left-2/Driver",
            "Lef/Driver",
            "Right/leg/Driver",
        ] {
            robots.moved(driver, Time::ZERO, at(0.0));
        }
        let goals = robots.all().map(|it| (it.name, it.to_goal_m()));
        let expected = [
            ("Lef", None),
            ("Left", Some(1.0)),
            ("Left-2", Some(0.0)),
            ("Right/leg", Some(2.0)),
        ];
        let mut goals: Vec<_> = goals.collect();
        goals.sort_by_key(|(name, _)| *name);
        assert_eq!(goals, expected);
    }

    #[test]
    fn a_robot_in_a_composite_of_its_own_has_the_goal_of_the_coordinator_outside() {
        let mut robots = Robots::default();
        robots.set_goal("Coordinator", at(3.0));
        robots.set_control_state("Coordinator", "FOLLOWING");
        robots.moved("base/Driver", Time::ZERO, at(1.0));
        let robot = robots.only().unwrap();
        assert_eq!(robot.to_goal_m(), Some(2.0));
        let state = robots
            .all()
            .next()
            .and_then(|robot| robot.control_state.map(str::to_owned));
        assert_eq!(state.as_deref(), Some("FOLLOWING"));
    }
}
