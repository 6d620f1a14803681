//! The trait of planners and its results.

use asmotion_component::Properties;
use asmotion_geometry::{Grid, Point, Pose};

/// Finds a path, or the reason that there is none. Called for each request, with the map of that request.
pub trait Planner: Send {
    /// A path for a round robot from `start` to `goal`, both in the map frame of `grid`.
    ///
    /// Equal arguments give equal results, regardless of earlier calls.
    ///
    /// # Errors
    /// An error if an end is outside the map, if the robot cannot stand at an end, or if no path connects the ends.
    fn plan(&mut self, grid: &Grid, start: &Pose, goal: &Pose) -> Result<PlannedPath, NoPath>;
}

/// The robot's needs and preferences.
#[derive(Clone, Debug, PartialEq, Properties)]
pub struct PlannerSettings {
    /// Smallest distance of the path from an occupied cell: the robot's radius and a margin.
    #[property(unit = "m", range = 0.0..=10.0, default = 0.3)]
    pub inflation_m: f64,
    /// Distance beyond the inflation within which the path is more expensive.
    #[property(unit = "m", range = 0.0..=10.0, default = 0.5)]
    pub comfort_m: f64,
    /// Price of driving within `comfort_m`: cost grows up to `1 + clearance_weight` times the length. With 0 the
    /// path is the shortest one that is allowed.
    #[property(range = 0.0..=20.0, default = 2.0)]
    pub clearance_weight: f64,
    /// Largest distance between two poses of the path.
    #[property(unit = "m", range = 0.0..=10.0, default = 0.1)]
    pub step_m: f64,
    /// Whether the path may cross cells of unknown occupancy.
    pub allow_unknown: bool,
}

impl PlannerSettings {
    /// Settings for the shortest allowed path, without preferring clearance.
    pub fn shortest(self) -> Self {
        Self {
            clearance_weight: 0.0,
            ..self
        }
    }
}

/// A path that was found.
#[derive(Clone, Debug, PartialEq)]
pub struct PlannedPath {
    /// Poses from the start's position, in the direction of the path, to the goal with its own yaw.
    pub poses: Vec<Pose>,
    /// Length along the poses, m.
    pub length: f64,
    /// Number of cells the search settled.
    pub explored: usize,
}

/// An end of the requested path.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PathEnd {
    /// Pose of the robot.
    Start,
    /// Requested pose.
    Goal,
}

impl std::fmt::Display for PathEnd {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Self::Start => "start",
            Self::Goal => "goal",
        })
    }
}

/// Reason why there is no path.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum NoPath {
    /// An end is outside the map.
    #[error("the {end} ({x:.2}, {y:.2}) m lies outside the map", x = at.x, y = at.y)]
    Outside {
        /// The end concerned.
        end: PathEnd,
        /// Its position, map frame, m.
        at: Point,
    },
    /// The robot stands in an occupied or unknown cell.
    #[error("the start ({x:.2}, {y:.2}) m is {why}", x = at.x, y = at.y)]
    StartOccupied {
        /// Position of the start, map frame, m.
        at: Point,
        /// The reason that the robot cannot stand there.
        why: Blocked,
    },
    /// The robot cannot stand at the goal.
    #[error("the goal ({x:.2}, {y:.2}) m is {why}", x = at.x, y = at.y)]
    GoalOccupied {
        /// Position of the goal, map frame, m.
        at: Point,
        /// The reason that the robot cannot stand there.
        why: Blocked,
    },
    /// All reachable cells were searched without reaching the goal.
    #[error("no way leads from the start to the goal ({explored} cells searched)")]
    Unreachable {
        /// Number of cells the search settled.
        explored: usize,
    },
}

/// The reason that a robot cannot stand in a cell.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Blocked {
    /// The cell is occupied.
    Occupied,
    /// Its occupancy is unknown, and `allow_unknown` is false.
    Unknown,
    /// An obstacle is too near.
    Near {
        /// Distance to the nearest obstacle, m.
        distance: f64,
        /// Smallest distance that is allowed, m.
        inflation: f64,
    },
}

impl std::fmt::Display for Blocked {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Occupied => f.write_str("occupied"),
            Self::Unknown => f.write_str("unknown; `allow_unknown` would let the robot go there"),
            Self::Near {
                distance,
                inflation,
            } => write!(
                f,
                "{distance:.2} m from an obstacle, nearer than `inflation_m` = {inflation:.2}"
            ),
        }
    }
}

impl NoPath {
    /// The fault code of the planning service.
    pub fn code(&self) -> &'static str {
        match self {
            Self::Outside { .. } => "OUTSIDE",
            Self::StartOccupied { .. } => "START_OCCUPIED",
            Self::GoalOccupied { .. } => "GOAL_OCCUPIED",
            Self::Unreachable { .. } => "NO_PATH",
        }
    }
}
