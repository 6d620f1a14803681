//! Path planning: planners on occupancy grids, and the component that provides them as a service.
//!
//! Metres and radians in the frame of the map (REP-103, REP-105).

mod astar;
mod component;
pub mod contract;
mod costs;
mod planner;
mod planners;
mod search;
mod smooth;

pub use self::component::TrajectoryPlanner;
pub use astar::AStar;
pub use planner::{Blocked, NoPath, PathEnd, PlannedPath, Planner, PlannerSettings};
pub use planners::{MakePlanner, PLANNERS, Planners};

/// Protocol of the planner: what it sends, depending on what it receives.
pub const PROTOCOL: &str = include_str!("../protocol.asm");
